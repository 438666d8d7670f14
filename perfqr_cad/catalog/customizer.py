"""Parameters on top of a template's source, as OpenSCAD's customizer comments declare them.

The comment behind a value is OpenSCAD's: `[max]`, `[min:max]`, `[min:step:max]`, `[a, b, c]`,
`[a:Label, b:Label]`, or a bare number (step of a number, longest length of a string). The comment above
a value describes it; `# [Tab]` starts a group, and the group `Hidden` is not listed. The kind of a value is
that of its default, or of its annotation (`point: tuple[float, float, float] | None = None`). A name that
is a Python keyword carries a trailing underscore in the file only: `-D yield=40` sets `yield_`.

`# [Shared: Code, Look]` takes in groups of the settings of `make`; `# [Shared]` takes them all. A value of
the same name then changes the default of that setting. Nothing of the template is run.
"""

from __future__ import annotations

import ast
import io
import keyword
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from perfqr_cad.errors import DesignError, TemplateError
from perfqr_cad.pipeline.kinds import Kind, Value, kind_of_annotation, kind_of_literal, value_of
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.request import SETTINGS
from perfqr_cad.pipeline.setting import GROUPS

HIDDEN = "Hidden"
_SHARED = re.compile(r"\[\s*Shared\s*(?::(?P<groups>[^\]]*))?\]")
_GROUP = re.compile(r"\[\s*([^\[\]:,]+?)\s*\]")


def parameters(source: str, tree: ast.Module) -> tuple[Parameter, ...]:
    """The parameters of a template in the order of its source; `tree` is the source parsed.

    Raises `TemplateError` for a shared group that there is none of, and for a default out of its limits.
    """
    text = _Source(source)
    own = {declared.name: (line, declared) for line, declared in _own(text, tree)}
    found: dict[str, tuple[int, Parameter]] = {}
    for line, groups in text.shared():
        for setting in SETTINGS:
            if setting.group in groups and setting.name not in found:
                changed = own.pop(setting.name, None)
                declared = _shared(setting, None if changed is None else changed[1])
                found[setting.name] = (line, declared)
    ordered = sorted([*found.values(), *own.values()], key=lambda entry: entry[0])
    return tuple(declared for _, declared in ordered if declared.group != HIDDEN)


def _own(text: _Source, tree: ast.Module) -> Iterator[tuple[int, Parameter]]:
    for node in tree.body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                annotation = None
            case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value):
                annotation = ast.unparse(node.annotation)
            case _:
                continue
        if name.startswith("_") or name.isupper():
            continue
        if (declared := _declared(name, value, annotation, text, node)) is not None:
            yield node.lineno, declared


def _declared(
    name: str, value: ast.expr, annotation: str | None, text: _Source, node: ast.stmt
) -> Parameter | None:
    """The parameter that an assignment declares; None where its value is no plain value."""
    try:
        default = ast.literal_eval(value)
    except (ValueError, TypeError, RecursionError, MemoryError):
        return None
    kind = kind_of_literal(default)
    named = None if annotation is None else kind_of_annotation(annotation)
    if kind is None:
        return None
    declared = Parameter(
        _public_name(name),
        tuple(default) if isinstance(default, list) else default,
        kind[0],
        text.description_above(node.lineno),
        text.group_above(node.lineno),
        lengths=kind[1],
        empty="" if default is None else None,
    )
    if named is not None:
        declared = replace(declared, kind=named[0], lengths=named[1], empty="" if named[2] else None)
    return replace(declared, **_limits(text.comment(node.end_lineno or node.lineno), declared))


def _shared(setting: Parameter, changed: Parameter | None) -> Parameter:
    """A setting of `make` as a template's parameter, with the default and limits that the template gives."""
    if changed is None:
        return replace(setting, default=setting.default if setting.example is None else setting.example)
    default = setting.read(changed.default)
    given = {
        name: getattr(changed, name)
        for name in ("description", "minimum", "step", "maximum", "choices", "max_length")
        if getattr(changed, name)
    }
    empty = setting.empty if default is None else None
    return replace(setting, default=default, empty=empty, **given)


@dataclass(frozen=True)
class _Source:
    """A template's source with its comments by line, from 1."""

    text: str

    @cached_property
    def lines(self) -> list[str]:
        return self.text.splitlines()

    @cached_property
    def comments(self) -> dict[int, str]:
        tokens = tokenize.generate_tokens(io.StringIO(self.text).readline)
        return {t.start[0]: t.string.lstrip("#").strip() for t in tokens if t.type == tokenize.COMMENT}

    def comment(self, line: int) -> str:
        return self.comments.get(line, "")

    def own_line(self, number: int) -> str | None:
        """The comment that has this line for itself."""
        if number in self.comments and self.lines[number - 1].lstrip().startswith("#"):
            return self.comments[number]
        return None

    def description_above(self, line: int) -> str:
        text = self.own_line(line - 1)
        return "" if text is None or _GROUP.fullmatch(text) or _SHARED.fullmatch(text) else text

    def group_above(self, line: int) -> str:
        for number in range(line - 1, 0, -1):
            text = self.own_line(number)
            if text and not _SHARED.fullmatch(text) and (group := _GROUP.fullmatch(text)):
                return group.group(1)
        return "Parameters"

    def shared(self) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Lines that take in groups of settings, and those groups."""
        for line in sorted(self.comments):
            found = _SHARED.fullmatch(self.own_line(line) or "")
            if found is None:
                continue
            named = found["groups"]
            groups = GROUPS if named is None else tuple(name.strip() for name in named.split(","))
            for group in groups:
                if group not in GROUPS:
                    raise TemplateError(
                        f"line {line}: there is no shared group {group!r}: take some of {', '.join(GROUPS)}"
                    )
            yield line, groups


def _limits(comment: str, declared: Parameter) -> dict[str, Any]:
    """OpenSCAD customizer widgets as attributes of `Parameter`."""
    bracket = re.match(r"\[(.*)\]", comment)
    numeric = declared.kind in (Kind.WHOLE, Kind.NUMBER, Kind.VECTOR)
    if bracket is None:
        number = re.match(r"\d{1,9}(\.\d+)?\b", comment)
        if number is None:
            return {}
        return {"step": float(number.group())} if numeric else {"max_length": int(float(number.group()))}
    inside = bracket.group(1)
    if numeric and "," not in inside:
        return _range(inside)
    pairs = (item.strip().partition(":") for item in inside.split(","))
    return {
        "choices": tuple(
            (_choice(declared, value.strip()), (label or value).strip()) for value, _, label in pairs
        )
    }


def _range(text: str) -> dict[str, float]:
    """`max`, `min:max` or `min:step:max`; nothing where it is no range, as OpenSCAD has it."""
    keys = {1: ("maximum",), 2: ("minimum", "maximum"), 3: ("minimum", "step", "maximum")}
    try:
        numbers = [value_of(Kind.NUMBER, part) for part in text.split(":")]
    except ValueError:
        return {}
    plain = [number for number in numbers if isinstance(number, float)]
    return dict(zip(keys[len(plain)], plain, strict=True)) if len(plain) in keys else {}


def _choice(declared: Parameter, text: str) -> Value:
    """A choice in the kind of its parameter; as text where it is none of that."""
    try:
        return declared.check(text)
    except DesignError:
        return text


def _public_name(name: str) -> str:
    bare = name[:-1]
    return bare if name.endswith("_") and keyword.iskeyword(bare) else name
