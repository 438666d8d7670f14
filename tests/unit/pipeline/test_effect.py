"""Whatever is set has an effect, or is refused before any work."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import pytest

from perfqr_cad.content import CONTENTS
from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.effect import require_files
from perfqr_cad.pipeline.kinds import Kind
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.request import SETTINGS, SOURCES, Request
from perfqr_cad.pipeline.resolve import Terms, resolve

BY_NAME = {declared.name: declared for declared in SETTINGS}

# A value other than the default, where the declaration leads to none.
OTHER: dict[str, Any] = {
    "text": "hello",
    "image": "code.png",
    "caption": "7",
    "font": "STIXGeneral",
    "hole": ((3.0,),),
    "load": "push",
    "colour": "red",
    "ground": "white",
    "legibility": "0.5",
    "require": "zbar",
    "freedom": "mask",
    "gs1_link": "example.com",
    **dict.fromkeys(CONTENTS, "given"),
    "bytes": "data.bin",
    "yield": 20.0,
    "size": 40.0,
    "caption_height": 3.0,
    "support": "clamped",
    "process": "laser",
}
BESIDE: dict[str, dict[str, Any]] = {  # what lets it take part, as captions stand on a frame
    "caption": {"frame_mm": 8.0},
    "hole": {"frame_mm": 8.0},
    "colour_change": {"backing_mm": 1.0},
}
# Where settings act that no layer's terms hold: the chain itself and the files.
ELSEWHERE = {
    **dict.fromkeys((*SOURCES, "gs1_link", "no_eci", "freedom", "legibility"), "the symbol"),
    **dict.fromkeys(("which", "level", "version", "mask"), "the symbol"),
    **dict.fromkeys(("thickness", "mirror"), "where it is carved"),
    **dict.fromkeys(("verify_solid", "require", "grade", "accept_weak", "accept_unread"), "what is checked"),
    **dict.fromkeys(("dxf", "dxf_bridges", "svg", "split_stl", "colour_change"), "the files"),
    "method": "how strength is sought",
}
NEEDING = [declared for declared in SETTINGS if any(not need.startswith(".") for need in declared.needs)]
OF_FILES = [declared for declared in SETTINGS if any(need.startswith(".") for need in declared.needs)]


def other(declared: Parameter) -> Any:
    if declared.name in OTHER:
        return OTHER[declared.name]
    if declared.kind is Kind.FLAG:
        return not declared.default
    if declared.choices:
        return next(value for value, _ in declared.choices if value != declared.default)
    assert declared.minimum is not None
    return max(1.0, declared.minimum) if declared.default != 1.0 else 2.0


def asked(**settings: Any) -> Request:
    return Request(**({} if settings.keys() & set(SOURCES) else {"text": "HELLO"}) | settings)


def giving(need: str) -> dict[str, Any]:
    name, equals, wanted = need.partition("=")
    return {BY_NAME[name].field: wanted if equals else other(BY_NAME[name]), **BESIDE.get(name, {})}


@pytest.mark.parametrize("declared", NEEDING, ids=lambda declared: declared.name)
def test_a_setting_without_what_it_needs_is_refused(declared: Parameter) -> None:
    given = {declared.field: other(declared)}
    lacking: dict[str, Any] = {"image": "code.png"} if "text" in declared.needs else {}
    lacking |= {"finder": "panel"} if "finder=recessed" in declared.needs else {}
    with pytest.raises(DesignError, match=f"{declared.name}=.* has no effect without ") as told:
        asked(**given, **lacking)
    assert str(told.value).endswith(f"no {declared.option}")
    for need in declared.needs:
        asked(**giving(need) | given)
    asked(**{declared.field: declared.default}, **lacking)  # the default is none of anybody's


@pytest.mark.parametrize("declared", OF_FILES, ids=lambda declared: declared.name)
def test_a_setting_of_files_of_which_none_is_written_is_refused(declared: Parameter) -> None:
    values = {one.name: one.default for one in SETTINGS} | {declared.name: other(declared)}
    with pytest.raises(DesignError, match=rf"no effect without a \..* file: use -o part{declared.needs[0]}"):
        require_files(SETTINGS, values, {".json"})
    require_files(SETTINGS, values, {".json", declared.needs[0]})
    require_files(SETTINGS, values | {declared.name: declared.default}, {".json"})


@pytest.mark.parametrize("declared", SETTINGS, ids=lambda declared: declared.name)
def test_every_setting_reaches_a_layer(declared: Parameter) -> None:
    """Beside what it needs, the terms of a layer are others, or it acts elsewhere."""
    beside: dict[str, Any] = dict(BESIDE.get(declared.name, {}))
    for need in declared.needs[:1]:
        beside |= {} if need.startswith(".") else giving(need)
    if declared.name in ("text", "image"):
        return
    with_it = terms(**beside | {declared.field: other(declared)})
    differ = [
        one.name for one in fields(Terms) if getattr(with_it, one.name) != getattr(terms(**beside), one.name)
    ]
    differ.remove("request")
    assert bool(differ) != (declared.name in ELSEWHERE), differ


def terms(**settings: Any) -> Terms:
    return resolve(asked(**settings), plate=True)


def test_needs_are_of_settings_and_files() -> None:
    for declared in SETTINGS:
        for need in declared.needs:
            name, equals, wanted = need.partition("=")
            if need.startswith("."):
                continue
            assert name in BY_NAME
            assert not equals or wanted in {value for value, _ in BY_NAME[name].choices}
