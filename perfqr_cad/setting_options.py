"""The settings of `make` as options of the command, made from their declarations.

Nothing is read here: an option's letters go to the parameter of the same name, whose kind decides.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.kinds import Kind, shown
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.request import SETTINGS, SOURCES
from perfqr_cad.pipeline.setting import GROUPS

_METAVARS = {Kind.TEXT: "TEXT", Kind.WHOLE: "NUMBER", Kind.NUMBER: "NUMBER", Kind.VECTORS: "D|X,Y,D;…"}


def with_settings(command: Callable[..., None]) -> Callable[..., None]:
    """A command that takes `**settings` with an option for each of them in its stead."""
    signature = inspect.signature(command, eval_str=True)
    own = [p for p in signature.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
    ordered = sorted(SETTINGS, key=lambda declared: GROUPS.index(declared.group))
    options = [
        inspect.Parameter(
            s.python_name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=_annotated(s)
        )
        for s in ordered
    ]
    command.__signature__ = inspect.Signature([*own, *options])  # pyright: ignore[reportFunctionMemberAccess]
    command.__annotations__ = {p.name: p.annotation for p in [*own, *options]}
    return command


def given(parameters: Mapping[str, Any], payload: str | None) -> dict[str, str]:
    """The settings among a command's parameters, as they were written; `payload` is the text without option.

    Raises `DesignError` where one is given twice with different values, of which one would have no effect.
    """
    found: dict[str, str] = {} if payload is None else {"text": payload}
    for declared in SETTINGS:
        value = parameters[declared.python_name]
        letters = ["true"] if value is True else list(value or ())
        if declared.kind is Kind.VECTORS and letters:
            letters = ["; ".join(letters)]
        for written in letters:
            found = joined(found, {declared.name: written})
    return found


def joined(first: Mapping[str, str], second: Mapping[str, str]) -> dict[str, str]:
    """Both together. Raises `DesignError` where they differ."""
    for name in first.keys() & second.keys():
        if first[name] != second[name]:
            raise DesignError(
                f"{name} is given twice, {shown(first[name])} and {shown(second[name])}: give it once"
            )
    return {**first, **second}


def over(sets: Mapping[str, Any], explicit: Mapping[str, str]) -> dict[str, Any]:
    """Parameter sets with what was given by name, which wins: a text also over the picture of a set.

    Raises `DesignError` where two things to encode are given by name.
    """
    named = [source for source in SOURCES if explicit.get(source)]
    if len(named) > 1:
        raise DesignError(f"{' and '.join(named)} are given together: give one of them")
    unseen = set(SOURCES) if named else set[str]()
    return {**{name: value for name, value in sets.items() if name not in unseen}, **explicit}


class Grouped(TyperCommand):
    """A command whose help lists its options in groups."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Arguments first, then each group under its name."""
        groups: dict[str, list[Any]] = {}
        for parameter in self.get_params(ctx):
            if record := parameter.get_help_record(ctx):
                groups.setdefault(_group(parameter), []).append(record)
        for name, records in groups.items():
            with formatter.section(name):
                formatter.write_dl(records)


def _group(parameter: Any) -> str:
    if parameter.param_type_name == "argument":
        return "Arguments"
    return getattr(parameter, "rich_help_panel", None) or "Options"


def _annotated(declared: Parameter) -> Any:
    help = typer.Option(declared.option, help=_help(declared), rich_help_panel=declared.group)
    if declared.kind is Kind.FLAG:
        return Annotated[bool | None, help]
    unit = "" if declared.kind is Kind.VECTORS else declared.unit.upper()
    help.metavar = "|".join(_names(declared.choices)) or unit or _METAVARS[declared.kind]
    return Annotated[list[str] | None, help]


def _names(choices: Iterable[tuple[Any, str]]) -> list[str]:
    return [str(value) for value, _ in choices]


def _help(declared: Parameter) -> str:
    text = declared.description[0].upper() + declared.description[1:]
    if declared.minimum is not None or declared.form:
        text += f": {declared.wanted}"
    notes = [f"{value}: {label}" for value, label in declared.choices if str(value) != label]
    notes += [f"not given: {declared.empty}"] if declared.empty else []
    if declared.default not in (None, False, ()):
        notes.append(f"default: {shown(declared.default).strip(chr(39))}")
    return f"{text} ({'; '.join(notes)})." if notes else f"{text}."
