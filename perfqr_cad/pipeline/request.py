"""What a user can ask for: one declaration per setting, from which everything else comes.

A field of `Request` named `size_mm` is the option `--size` and the parameter `size` of a template: the three
differ by the unit alone. Its declaration holds meaning, range, group and what happens where nothing is
given; the options of `perfqr make`, the parameters that templates share, `perfqr params`, the JSON Schema,
docs/settings.md and `help(make)` are made from it. A new setting is one field here and the code that obeys.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from perfqr_cad.content import CONTENTS
from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.effect import require_effect
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.setting import declarations, listed, setting

MOST_LETTERS = 7089  # of a payload, all digits: version 40-L, ISO/IEC 18004 Table 7
# What all kinds of content share (`perfqr_cad.content`): parts, or @FILE with a part a line.
CONTENT: dict[str, Any] = {"empty": "none", "max_length": MOST_LETTERS, "visible": True}
WRITTEN = ("text", "bytes", *CONTENTS)  # what a code is drawn from
SOURCES = ("text", "image", *WRITTEN[1:])  # exactly one of them is given
LOADS = ("load", "pressure", "finger", "own_weight", "handling")  # settings that ask for strength
AUTO = "auto"
CUT = ("laser", "waterjet", "knife", "stencil")  # processes that cut sheets
MOST_CAPTION = 500  # letters that a frame could bear


@dataclass(frozen=True)
class Request:
    """Every setting of a part.

    Raises `DesignError` for values that cannot be meant; each layer checks its own more closely."""

    text: str | None = setting(
        None,
        "the text of the code",
        group="Code",
        empty="the picture's",
        max_length=MOST_LETTERS,
        visible=True,
        example="https://example.com",
    )
    image: str | None = setting(
        None, "a picture of a code, instead of a text", group="Code", empty="none", visible=True
    )
    url: str | None = setting(
        None, "a web address, instead of a text; escaped where needed", group="Code", **CONTENT
    )
    wifi: str | None = setting(
        None, "a login: ssid=…; password=…; security=WPA, WEP or nopass; hidden=yes", group="Code", **CONTENT
    )
    vcard: str | None = setting(
        None, "a business card: name=…; org=…; phone=…; email=…; url=…; city=… …", group="Code", **CONTENT
    )
    event: str | None = setting(
        None, "an event: title=…; start=2027-05-01T10:00; end=…; place=…; text=…", group="Code", **CONTENT
    )
    geo: str | None = setting(None, "a place: latitude,longitude in degrees", group="Code", **CONTENT)
    epc: str | None = setting(
        None, "a SEPA transfer: name=…; iban=…; amount=…; text=… or reference=…", group="Code", **CONTENT
    )
    sms: str | None = setting(None, "a short message: to=+41…; text=…", group="Code", **CONTENT)
    tel: str | None = setting(None, "a telephone number", group="Code", **CONTENT)
    email: str | None = setting(None, "a letter: to=…; subject=…; body=…", group="Code", **CONTENT)
    gs1: str | None = setting(
        None, "GS1 elements: (01)09506000134352(10)AB-1, marked by FNC1", group="Code", **CONTENT
    )
    gs1_link: str | None = setting(
        None,
        "a domain, such as https://id.gs1.org: the GS1 elements become an address there (Digital Link)",
        group="Code",
        needs=("gs1",),
        empty="an element string",
        max_length=200,
        visible=True,
    )
    bytes: str | None = setting(
        None, "a file whose bytes are the code's content", group="Code", empty="none", visible=True
    )
    no_eci: bool = setting(
        False,
        "text beyond ASCII goes without its label as UTF-8 (ECI 26): some readers then guess wrong",
        group="Code",
        needs=WRITTEN,
    )
    which: int | None = setting(
        None,
        "which of several codes in the picture",
        group="Code",
        needs=("image",),
        range=(1, 100),
        empty="the only one",
    )
    legibility: str | None = setting(
        None,
        "how far the art of a picture gives way to the plain code, 0 to 1, or auto: as far as decoders need",
        group="Code",
        needs=("image",),
        empty="not at all",
        max_length=10,
    )
    level: str = setting(
        "M",
        "error correction level",
        group="Code",
        needs=WRITTEN,
        choices=("L:7 %", "M:15 %", "Q:25 %", "H:30 %"),
    )
    version: int | None = setting(
        None,
        "symbol version",
        group="Code",
        needs=WRITTEN,
        range=(1, 40),
        empty="the smallest that fits, or the next",
    )
    mask: int | None = setting(
        None,
        "mask of the symbol",
        group="Code",
        needs=WRITTEN,
        range=(0, 7),
        empty="the one that needs the fewest bridges",
    )
    freedom: str = setting(
        "mask,segment,pad,version",
        "what of a text's code may be chosen so that it needs fewer bridges, with commas between: mask,"
        " segment (cut in several modes), pad (bits after its end), version (the next larger one), case"
        " (scheme and host of an address in capitals, on request); or none",
        group="Code",
        needs=WRITTEN,
        max_length=100,
    )
    size_mm: float | None = setting(
        None,
        "edge of the whole code with its quiet zone",
        group="Code",
        range=(1.0, 10_000.0),
        empty="the smallest that the nozzle makes",
    )
    quiet_modules: int = setting(4, "light margin around the code", group="Code", range=(1, 20))
    style: str = setting(
        "square",
        "shape of the modules",
        group="Look",
        choices=("square", "rounded", "dots", "diamond", "bars"),
    )
    fillet_mm: float | None = setting(
        None, "radius of re-entrant corners", group="Look", range=(0.0, 100.0), empty="half the nozzle"
    )
    tone: str = setting(
        "normal",
        "which modules are material",
        group="Look",
        choices=("normal:light modules", "inverted:dark modules"),
    )
    contour: str = setting(
        "smooth",
        "edges of free-form art",
        group="Look",
        needs=("image",),
        choices=("smooth:curves", "exact:the pixels' own"),
    )
    finder: str = setting(
        "recessed",
        "how the finder rings are held",
        group="Look",
        choices=("recessed:at the back", "panel:flush bars", "diagonal:four corner bars"),
    )
    bars: int | None = setting(
        None,
        "recessed bars of a finder ring",
        group="Look",
        needs=("finder=recessed",),
        range=(1, 3),
        empty="as reads best",
    )
    bar_height_mm: float | None = setting(
        None,
        "their height above the back",
        group="Look",
        needs=("finder=recessed",),
        range=(0.05, 100.0),
        empty="as reads best",
    )
    bar_width_mm: float | None = setting(
        None,
        "their width",
        group="Look",
        needs=("finder=recessed",),
        range=(0.05, 100.0),
        empty="as reads best",
    )
    objective: str = setting(
        "optimal",
        "how bridges are chosen",
        group="Look",
        choices=("optimal:fewest and least harmful", "paper:Eq. (4)", "mst:Eq. (4) with λ = 0"),
    )
    process: str = setting(
        "fdm",
        "how the part is made, and so what can be designed",
        group="Walls",
        choices=(
            "fdm:printed from filament",
            "resin:printed from resin",
            "laser:cut from a sheet",
            "waterjet:cut from a sheet",
            "knife:cut from card or film",
            "stencil:cut, to paint through",
        ),
    )
    nozzle_mm: float = setting(0.4, "width of one printed line", group="Walls", range=(0.01, 10.0))
    kerf_mm: float = setting(
        0.0,
        "width that the cutter takes away; paths in DXF and SVG files keep half of it off the part,"
        " 0 leaves that to the cutter's program",
        group="Walls",
        needs=tuple(f"process={way}" for way in CUT),
        range=(0.0, 10.0),
    )
    draft_deg: float | None = setting(
        None,
        "flare of the hole walls towards the back",
        group="Walls",
        range=(0.0, 60.0),
        empty="plates with through-holes flare as far as it helps the reader, all else is straight",
    )
    lip_mm: float | None = setting(
        None,
        "straight lip in front of flared walls",
        group="Walls",
        range=(0.0, 500.0),
        empty="suits the flare",
    )
    depth_mm: float | None = setting(
        None,
        "depth of blind pockets instead of through-holes",
        group="Walls",
        range=(0.01, 500.0),
        empty="through",
    )
    thickness_mm: float = setting(1.6, "thickness of the plate", group="Body", range=(0.05, 500.0))
    frame_mm: float = setting(
        0.0, "width of a frame around the quiet zone", group="Body", range=(0.0, 1000.0)
    )
    corner_radius_mm: float = setting(0.0, "radius of the outer corners", group="Body", range=(0.0, 1000.0))
    hole_mm: tuple[tuple[float, ...], ...] = setting(
        (),
        "mounting holes in the frame, from the centre of the code",
        group="Body",
        lengths=(1, 3),
        form="a diameter for one hole in each corner, or x,y,diameter, mm; several with ; between",
    )
    caption: str | None = setting(
        None,
        "text on the frame; a new line begins another line",
        group="Body",
        empty="none",
        max_length=MOST_CAPTION,
        visible=True,
    )
    caption_height_mm: float | None = setting(
        None,
        "height of the caption's capital letters",
        group="Body",
        needs=("caption",),
        range=(0.1, 1000.0),
        empty="half of the frame, or what its lines leave",
    )
    caption_place: str = setting(
        "bottom",
        "on which side of the code the caption stands",
        group="Body",
        needs=("caption",),
        choices=("bottom:below", "top:above"),
    )
    font: str | None = setting(
        None,
        "font of the caption: the name of an installed one, or a file",
        group="Body",
        needs=("caption",),
        empty="DejaVu Sans, which comes along",
        visible=True,
    )
    caption_relief_mm: float = setting(
        0.4,
        "how far letters stand out of the face; below 0 they are engraved",
        group="Body",
        needs=("caption",),
        range=(-100.0, 100.0),
    )
    backing_mm: float | None = setting(
        None,
        "thickness of a plate behind the part, in the tone of the holes",
        group="Body",
        range=(0.05, 500.0),
        empty="none",
    )
    gap_mm: float = setting(
        0.0, "gap before the backing", group="Body", needs=("backing",), range=(0.0, 500.0)
    )
    mirror: bool = setting(
        False, "the face is drawn mirrored, to be read from behind: for stamps and moulds", group="Body"
    )
    material: str = setting(
        "PLA",
        "what the part is made of",
        group="Strength",
        choices=("PLA", "PETG", "ABS", "PA12", "resin", "aluminium", "steel", "stainless"),
    )
    load: str | None = setting(
        None,
        "what the part must bear: weight, fingertip, push, bend, twist, peel, pressure, with commas between;"
        " a name alone picks, NAME=N asks for that many newtons beside the others",
        group="Strength",
        empty="all that a hand does to it; bridges for strength only where something is asked for",
        max_length=200,
    )
    pressure_mpa: float = setting(
        0.0, "uniform pressure that the front must bear", group="Strength", range=(0.0, 1000.0)
    )
    finger_n: float | None = setting(
        None,
        "a fingertip's force that the part must bear at any place, as load fingertip=N",
        group="Strength",
        range=(0.01, 1e5),
        empty="not asked for",
    )
    own_weight: bool = setting(False, "the part must bear its own weight, as load weight", group="Strength")
    handling_n: float | None = setting(
        None,
        "a fingertip's force for which bars and thickness are changed until the part bears it",
        group="Strength",
        range=(0.01, 1e5),
        empty="not asked for",
    )
    support: str | None = setting(
        None,
        "how the code's square is held",
        group="Strength",
        choices=("free:in the hand", "clamped", "simple", "two-sides", "corners"),
        empty="in the hand; clamped where the wall goes on around the code",
    )
    yield_mpa: float | None = setting(
        None, "yield stress", group="Strength", range=(1e-3, 1e5), empty="the material's own"
    )
    method: str = setting(
        "optimal",
        "how bridges for strength are chosen",
        group="Strength",
        needs=LOADS,
        choices=("optimal:fewest and least harmful", "paper:Algorithm 1"),
    )
    verify_solid: bool = setting(False, "check the strength once more in three dimensions", group="Strength")
    colour: str | None = setting(
        None,
        "colour of the part: white, natural, yellow, orange, silver, red, green, blue, grey, black, #rrggbb",
        group="Proof",
        empty="white, or black for the inverted tone",
    )
    ground: str | None = setting(
        None,
        "colour behind it: white, black, red, green, blue, cyan, magenta, yellow, #rrggbb",
        group="Proof",
        empty="black, or white for the inverted tone",
    )
    scan_tilt_deg: float | None = setting(
        None,
        "tilt at which the part must still read",
        group="Proof",
        range=(1.0, 60.0),
        empty="nothing is asked beyond the view from straight above",
    )
    require: str | None = setting(
        None,
        "decoders that must read the part, by name with commas between",
        group="Proof",
        empty="any two",
        max_length=200,
    )
    grade: str | None = setting(
        None,
        "grade of print quality that the part must have, by ISO/IEC 15415; bars are chosen for it",
        group="Proof",
        choices=("A:3.5", "B:2.5", "C:1.5", "D:0.5"),
        empty="not asked for",
    )
    accept_weak: bool = setting(
        False,
        "write the part although it does not bear a load that was asked for",
        group="Proof",
        needs=LOADS,
    )
    accept_unread: bool = setting(
        False, "write the part although it is not read as it should be", group="Proof"
    )
    seed: int = setting(0, "seed of everything random", group="Proof", range=(0, 2**32 - 1))

    dxf: str = setting(
        "r2000",
        "version of DXF files",
        group="Files",
        needs=(".dxf",),
        choices=("r2000", "r12:for old programs"),
    )
    dxf_bridges: bool = setting(
        False, "draw bridges in DXF files, on a frozen layer", group="Files", needs=(".dxf",)
    )
    svg: str = setting(
        "filled",
        "kind of SVG files",
        group="Files",
        needs=(".svg",),
        choices=("filled:a picture", "cut:hairlines in the colours of a cutter"),
    )
    split_stl: bool = setting(
        False,
        "an STL file for each colour: part-backing.stl beside part.stl",
        group="Files",
        needs=(".stl",),
    )
    colour_change: bool = setting(
        False,
        "3MF files change the colour between layers, for one nozzle, not the tool",
        group="Files",
        needs=(".3mf",),
    )

    def __post_init__(self) -> None:
        given = [name for name in SOURCES if getattr(self, name) is not None]
        if not given:
            raise DesignError("nothing to encode: give a text, an image, or a content such as url or wifi")
        if len(given) > 1:
            raise DesignError(f"{' and '.join(given)} are given together: give one of them, not both")
        for declared in SETTINGS:
            value = declared.check(getattr(self, declared.field), declared.field)
            object.__setattr__(self, declared.field, value)
        require_effect(SETTINGS, {declared.name: getattr(self, declared.field) for declared in SETTINGS})
        if self.legibility is not None:
            _share(self.legibility)
        if len([hole for hole in self.hole_mm if len(hole) == 1]) > 1:
            raise DesignError("hole: two diameters for the holes in the corners: give one, or x,y,diameter")

    def as_dict(self) -> dict[str, Any]:
        """The settings as plain JSON values."""
        return asdict(self)


def _share(legibility: str) -> None:
    """Raises `DesignError` for a legibility that is neither a share nor auto."""
    try:
        meant = legibility == AUTO or 0 <= float(legibility) <= 1
    except ValueError:
        meant = False
    if not meant:
        raise DesignError(f"legibility {legibility!r} is neither {AUTO} nor a number from 0 to 1: try 0.5")


SETTINGS: tuple[Parameter, ...] = declarations(Request)
Request.__doc__ = f"{Request.__doc__}\n\n{listed(SETTINGS)}"
