"""Requests drawn from the declarations of the settings: a setting that is declared is drawn, by itself."""

from __future__ import annotations

import math
import random
import shlex
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import segno

from perfqr_cad import catalog
from perfqr_cad.pipeline.kinds import Kind
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.request import SETTINGS, SOURCES

BY_FIELD = {declared.field: declared for declared in SETTINGS}
GIVEN, RARELY = 0.15, 0.02  # shares of requests that give a setting
AT_END, WRONG = 0.04, 0.03  # shares of given settings
COSTLY = (
    "verify_solid",
    "handling_n",
    "scan_tilt_deg",
    "finger_n",
    "load",
    "pressure_mpa",
)  # many parts each
OF_OTHERS = ("contour", "which", "no_eci", "gs1_link", "method", "dxf", "dxf_bridges")  # seldom of use
LARGE = ("text", "version", "seed", "quiet_modules")  # whose upper end makes a part of minutes
MOST_LETTERS = 12  # behind the first: up to version 4
TEMPLATES = ("plate",) * 30 + ("bottle", "sphere")
WRONG_LETTERS = ("abc", "", "nan", "inf", "1e999", "-7.5", "0x10", "1,2,3", "true", "[1]", "\t", "é" * 300)
WRONG_VALUES = ("abc", "", math.nan, math.inf, 10**400, -7.5, [1], {"a": 1}, b"x", True, (), object)

# What people write where the declaration knows letters alone; the odd ones are refused.
WRITTEN: dict[str, tuple[Any, ...]] = {
    "caption": ("perfqr", "Tür 7", "A\nB", "été", "漢字"),
    "font": ("DejaVu Sans", "DejaVu Sans", "no such font"),
    "load": ("weight", "fingertip=0.2", "push=0.1,bend=0.1", "fingertip=40", "wind"),
    "require": ("zxing-cpp", "opencv", "zbar,opencv", "eyes"),
    "colour": ("white", "silver", "natural", "#e0e0f0", "grey", "pink"),
    "ground": ("black", "black", "red", "#102030", "yellow"),
    "hole_mm": (((3.0,),), ((3.0,),), ((0.0, 21.0, 2.0),), ((0.0, 0.0, 3.0),), ((2.0,), (3.0,))),
}

WRITTEN |= {
    "url": ("https://example.com/a b", "example.com"),
    "wifi": ("ssid=lab; password=1234 5678", "ssid=a\\;b; security=nopass", "lab"),
    "vcard": ("name=Zoë Å; phone=+41 44 000 00 00",),
    "event": ("title=Tea; start=2027-05-01T10:00",),
    "geo": ("47.37,8.54", "91,0"),
    "epc": ("name=A; iban=DE89370400440532013000; amount=1.50",),
    "sms": ("to=+41440000000; text=hi",),
    "tel": ("+41440000000",),
    "email": ("to=a@example.com; subject=ä",),
    "gs1": ("(01)09506000134352(10)AB-1", "(01)1"),
    "gs1_link": ("https://id.gs1.org",),
    "bytes": ("no such file",),
    "freedom": ("none", "mask", "mask,pad", "all"),
}

# Usual sizes where the range is far wider and there is no default, in the unit of the name.
USUAL = {
    "size_mm": (30.0, 70.0),
    "fillet_mm": (0.0, 0.4),
    "bar_height_mm": (0.3, 1.2),
    "bar_width_mm": (0.4, 1.0),
    "lip_mm": (0.0, 0.6),
    "depth_mm": (0.4, 1.4),
    "draft_deg": (0.0, 20.0),
    "caption_height_mm": (2.0, 6.0),
    "backing_mm": (0.4, 2.0),
    "yield_mpa": (20.0, 200.0),
    "bars": (1, 2),
}

# What a setting is of no use without; left out in some requests, which are refused then.
LETTERS: dict[str, Any] = {"caption": "perfqr", "frame_mm": 12.0}
NEEDED: dict[str, dict[str, Any]] = {
    "caption": {"frame_mm": 12.0},
    "hole_mm": {"frame_mm": 8.0},
    "gs1_link": {"gs1": "(01)09506000134352"},
    "gap_mm": {"backing_mm": 1.0},
    **dict.fromkeys(("caption_height_mm", "caption_place", "caption_relief_mm", "font"), LETTERS),
    **{key: {"load": "push=0.1"} for key in ("method", "accept_weak")},
}
FORGOTTEN = 0.2


@dataclass(frozen=True)
class Asked:
    """A request as it goes through a door.

    settings   by name in Python, as they were given
    command    through the command line, or through `make` in Python
    """

    seed: int
    template: str
    command: bool
    settings: dict[str, Any]

    def arguments(self, outputs: list[str]) -> list[str]:
        """The command line."""
        written = ["make", "-t", self.template]
        for field, value in self.settings.items():
            option = BY_FIELD[field].option
            if BY_FIELD[field].kind is Kind.FLAG:
                written += [option] if value else []
            else:
                written.append(f"{option}={_letters(value)}")
        return [*written, *(part for output in outputs for part in ("-o", output))]

    def line(self) -> str:
        """What a person would type for it."""
        if self.command:
            return shlex.join(["python", "-m", "perfqr_cad", *self.arguments(["part.stl", "part.svg"])])
        return f"from perfqr_cad import make; make(**{self.settings!r})"

    def without(self, field: str) -> Asked:
        return replace(self, settings={name: v for name, v in self.settings.items() if name != field})

    def changed(self, settings: dict[str, Any]) -> Asked:
        """With other values; None takes a setting out."""
        merged = self.settings | settings
        return replace(self, settings={name: value for name, value in merged.items() if value is not None})


def draw(seed: int, pictures: Path) -> Asked:
    """The request of a seed; the picture that it may name is made in `pictures`."""
    chance = random.Random(seed)
    template = chance.choice(TEMPLATES)
    command = seed % 2 == 0 or template != "plate"
    settings: dict[str, Any] = {"text": _text(chance)}
    taken = {parameter.name for parameter in catalog.find(template).parameters}
    for declared in [one for one in SETTINGS if one.name in taken]:
        share = RARELY if declared.field in (*COSTLY, *SOURCES, *OF_OTHERS) else GIVEN
        if chance.random() < share:
            settings[declared.field] = _value(declared, chance, command)
    for field in sorted(NEEDED.keys() & settings.keys()):
        if chance.random() > FORGOTTEN:
            settings = NEEDED[field] | settings
    if "image" in settings:
        settings["image"] = _picture(settings["text"], pictures / f"{seed}.png")
    if settings.keys() & set(SOURCES[1:]) and chance.random() < 0.9:  # the rest names two, which is refused
        del settings["text"]
    return Asked(seed, template, command, settings)


def _value(declared: Parameter, chance: random.Random, command: bool) -> Any:
    odd = chance.random()
    if odd < WRONG and declared.kind is not Kind.FLAG:
        return chance.choice(WRONG_LETTERS if command else WRONG_VALUES)
    if odd < WRONG + AT_END and declared.minimum is not None and declared.maximum is not None:
        ends = [declared.minimum, declared.minimum - 1]
        ends += [declared.maximum + 1] if declared.field in LARGE else [declared.maximum]
        return _of_kind(declared, chance.choice(ends))
    if declared.field in WRITTEN:
        return chance.choice(WRITTEN[declared.field])
    if declared.choices:
        return chance.choice(declared.choices)[0]
    if declared.kind in (Kind.WHOLE, Kind.NUMBER):
        return _of_kind(declared, _number(declared, chance))
    return True if declared.kind is Kind.FLAG else _text(chance)


def _number(declared: Parameter, chance: random.Random) -> float:
    """Near the default, or of the size of things that stand on a desk."""
    if declared.default:
        near = float(declared.default) * chance.choice((0.6, 0.75, 1.0, 1.5, 2.0))  # pyright: ignore
    elif declared.field in USUAL:
        near = chance.uniform(*USUAL[declared.field])
    elif declared.kind is Kind.WHOLE:
        near = chance.randint(1, 4)
    else:
        near = 10 ** chance.uniform(-0.7, 1.1)
    low = -math.inf if declared.minimum is None else declared.minimum
    high = math.inf if declared.maximum is None else declared.maximum
    return round(min(max(near, low), high), 2)


def _of_kind(declared: Parameter, number: float) -> float:
    return round(number) if declared.kind is Kind.WHOLE else float(number)


def _text(chance: random.Random) -> str:
    alphabet = chance.choice(("0123456789", "ABCXYZ-./: 012", "abcxyz/.:-_~%", "äöü語ключ€😀", "+1.50e"))
    return "x" + "".join(chance.choices(alphabet, k=chance.randint(0, MOST_LETTERS)))


def _picture(text: str, path: Path) -> str:
    path.parent.mkdir(parents=True, exist_ok=True)
    segno.make(text, micro=False).save(str(path), scale=8)
    return str(path)


def _letters(value: Any) -> str:
    if isinstance(value, tuple):
        return "; ".join(",".join(f"{number:g}" for number in vector) for vector in value)
    return str(value)
