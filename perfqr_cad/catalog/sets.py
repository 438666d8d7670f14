"""Values from outside: definitions (`-D name=value`) and OpenSCAD's parameter sets (`-p FILE -P NAME`).

What is given stays as it was written until the parameter reads it by its kind: `-D text=1.50` is a text.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from perfqr_cad.bounded import read_json
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
    found = read_json(path, MOST_BYTES, TemplateError, "a file of parameter sets", numbers=str)
    sets = found.get("parameterSets") if isinstance(found, dict) else None
    if not isinstance(sets, dict):
        raise TemplateError(
            f"{path.name} is no OpenSCAD parameter-set file: it needs a 'parameterSets' object"
        )
    return sets
