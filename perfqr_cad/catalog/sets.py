"""Values from outside: definitions (`-D name=value`) and OpenSCAD's parameter sets (`-p FILE -P NAME`).

What is given stays as it was written until the parameter reads it by its kind: `-D text=1.50` is a text.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NoReturn

from perfqr_cad.errors import TemplateError
from perfqr_cad.pipeline.kinds import shown

MOST_BYTES = 2_000_000  # of a file of parameter sets; OpenSCAD's own hold some hundred bytes a set


def read_definition(text: str) -> tuple[str, str]:
    """Name and letters of `name=value`."""
    name, equals, value = text.partition("=")
    name = name.strip()
    if not equals or not name.isidentifier():
        raise TemplateError(f"-D {shown(text)} is not name=value: write -D size=40, say")
    return name, value


def read_definitions(texts: Iterable[str]) -> dict[str, str]:
    """All `-D`. Raises `TemplateError` where two give one name different values."""
    read: dict[str, str] = {}
    for text in texts:
        name, value = read_definition(text)
        if read.setdefault(name, value) != value:
            raise TemplateError(
                f"-D {name} is given twice, {shown(read[name])} and {shown(value)}: give it once"
            )
    return read


def read_parameter_set(path: Path, name: str) -> dict[str, Any]:
    """The set `name` of an OpenSCAD customizer JSON file (`parameterSets`).

    Numbers keep the letters that they are written with, so that a text may be one.
    """
    sets = _sets(path)
    if not isinstance(sets.get(name), dict):
        known = ", ".join(sets) or "none"
        raise TemplateError(f"{path.name} has no parameter set {shown(name)}: it has {known}")
    return sets[name]


def _sets(path: Path) -> dict[str, Any]:
    try:
        if not path.is_file():
            raise TemplateError(f"cannot read parameter sets {shown(str(path))}: there is no such file")
        if path.stat().st_size > MOST_BYTES:
            raise TemplateError(f"{path.name} has over {MOST_BYTES:,} bytes: give a file of parameter sets")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise TemplateError(f"cannot read parameter sets {shown(str(path))}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise _no_sets(path) from error
    try:
        sets = json.loads(text, parse_int=str, parse_float=str, parse_constant=_no_number)["parameterSets"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise _no_sets(path) from error
    if not isinstance(sets, dict):
        raise _no_sets(path)
    return sets


def _no_sets(path: Path) -> TemplateError:
    return TemplateError(f"{path.name} is no OpenSCAD parameter-set file: it needs a 'parameterSets' object")


def _no_number(word: str) -> NoReturn:
    raise ValueError(f"{word} is no JSON")
