"""Remedies: changes of settings that a refusal names.

All of them are made here, so that what a message says is what was meant, in options that can be pasted, and a
test can apply each (`tests/unit/test_remedies.py` lists where they are made).
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import Any

UNITS = {"mm": "mm", "deg": "°", "mpa": "MPa", "n": "N", "modules": "modules"}  # by suffix of the Python name
TRIED = "which was tried"

Setting = str | float | bool | None  # a value to give, True for a flag, None to leave a setting out


class Remedy:
    """Settings by name in Python, with the values that they should have.

    >>> print(Remedy(size_mm=60.0, finder="panel"))
    --size 60 --finder panel
    >>> print(Remedy(colour=None, ground=None), Remedy(font="DejaVu Sans", mirror=True), sep="; ")
    no --colour and no --ground; --font 'DejaVu Sans' --mirror
    """

    def __init__(self, **changes: Setting) -> None:
        self.changes: dict[str, Any] = changes

    def __str__(self) -> str:
        given = " ".join(_written(name, value) for name, value in self.changes.items() if value is not None)
        left_out = [f"no {option(name)}" for name, value in self.changes.items() if value is None]
        return " and ".join([*filter(None, [given]), *left_out])


class Tried(Remedy):
    """A change with which the part was made."""

    def __str__(self) -> str:
        return f"{super().__str__()}, {TRIED}"


def option(name: str) -> str:
    """The option of a setting: its name in Python without the unit.

    >>> option("bar_height_mm")
    '--bar-height'
    """
    stem, _, suffix = name.rpartition("_")
    return f"--{(stem if suffix in UNITS else name).replace('_', '-')}"


def advice(remedies: Sequence[Remedy | str]) -> str:
    """What a message says of them.

    >>> advice([Remedy(size_mm=24.2), "a finer nozzle"])
    'use --size 24.2 or a finer nozzle'
    """
    *first, last = map(str, remedies)
    return f"use {', '.join(first)}{' or ' if first else ''}{last}"


def _written(name: str, value: Setting) -> str:
    if value is True:
        return option(name)
    letters = f"{value:.10g}" if isinstance(value, int | float) else shlex.quote(str(value))
    return f"{option(name)} {letters}"
