"""How a setting is declared: as a field of `Request` with metadata, read back as a `Parameter`."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from dataclasses import field, fields
from typing import Any, TypeVar, cast

from perfqr_cad.pipeline.kinds import Value, kind_of_annotation
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.remedy import UNITS

Function = TypeVar("Function", bound=Callable[..., Any])

GROUPS = ("Code", "Look", "Walls", "Body", "Strength", "Proof", "Files")
_WIDTH = 106


def setting(
    default: Any,
    help: str,
    *,
    group: str,
    range: tuple[float, float] | None = None,
    choices: tuple[str, ...] = (),
    empty: str | None = None,
    **more: Any,
) -> Any:
    """A field of `Request` with its declaration.

    help      its meaning, in a few words
    group     one of `GROUPS`
    range     least and most, in the unit of the name. The ends are far beyond any printer, cutter or press;
              they catch slips of unit
    choices   `value`, or `value:what it means`
    empty     what the program does where nothing is given; None: the default is a value
    more      further attributes of `Parameter`
    """
    low, high = range or (None, None)
    pairs = tuple(
        (value, label or value) for value, _, label in (choice.partition(":") for choice in choices)
    )
    declared = {"description": help, "group": group, "minimum": low, "maximum": high, "choices": pairs}
    return field(default=default, metadata={**declared, "empty": empty, **more})


def declarations(declaring: type) -> tuple[Parameter, ...]:
    """The settings that a dataclass declares, in its order.

    The name in Python is that of the option and of the template's parameter with the unit behind it.
    """
    found: list[Parameter] = []
    for entry in fields(declaring):
        kind = kind_of_annotation(str(entry.type))
        assert kind is not None, f"{entry.name}: no value of {entry.type} can be read"
        name, _, suffix = entry.name.rpartition("_")
        unit = UNITS.get(suffix, "")
        found.append(
            Parameter(
                name if unit else entry.name,
                cast(Value, entry.default),
                kind[0],
                unit=unit,
                field=entry.name,
                **entry.metadata,
            )
        )
    return tuple(found)


def listed(settings: tuple[Parameter, ...]) -> str:
    """The settings for `help()`: name, kind, range with unit, meaning, in their groups."""
    lines: list[str] = []
    for group in GROUPS:
        lines.append(f"{group}:")
        for declared in settings:
            if declared.group == group:
                text = f"{declared.meaning}; {declared.wanted}"
                lines += textwrap.wrap(
                    text, _WIDTH, initial_indent=f"  {declared.field:18} ", subsequent_indent=" " * 21
                )
    return "\n".join(lines)


def takes(settings: tuple[Parameter, ...]) -> Callable[[Function], Function]:
    """A decorator for a function that hands `**settings` on: `help()` lists each of them."""

    def documented(function: Function) -> Function:
        own = inspect.signature(function).parameters
        named = [p for p in own.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
        more = [
            inspect.Parameter(s.field, inspect.Parameter.KEYWORD_ONLY, default=s.default)
            for s in settings
            if s.field not in own
        ]
        function.__signature__ = inspect.Signature([*named, *more])  # pyright: ignore[reportFunctionMemberAccess]
        function.__doc__ = f"{inspect.getdoc(function)}\n\n{listed(settings)}"
        return function

    return documented
