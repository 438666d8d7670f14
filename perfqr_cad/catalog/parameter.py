"""Parameters of a template: their limits as OpenSCAD's customizer comments state them, read without running.

The comment behind a value is OpenSCAD's: `[max]`, `[min:max]`, `[min:step:max]`, `[a, b, c]`,
`[a:Label, b:Label]`, or a bare number (step of a number, longest length of a string). The comment above
a value describes it; `# [Tab]` starts a group, and the group `Hidden` is not listed. A name that is a
Python keyword carries a trailing underscore in the file only: `-D yield=40` sets `yield_`.
"""

from __future__ import annotations

import ast
import io
import keyword
import re
import tokenize
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from perfqr_cad.errors import TemplateError

Value = bool | int | float | str | tuple[float, ...] | None


@dataclass(frozen=True)
class Parameter:
    """One settable value of a template.

    `minimum`, `step`, `maximum` bound a number (or each entry of a vector); `choices` lists
    `(value, label)` pairs; `max_length` bounds a string.
    """

    name: str
    default: Value
    description: str = ""
    group: str = "Parameters"
    minimum: float | None = None
    step: float | None = None
    maximum: float | None = None
    choices: tuple[tuple[Value, str], ...] = ()
    max_length: int | None = None

    @property
    def limits(self) -> str:
        """The allowed values in OpenSCAD's own notation, empty when anything of the type goes."""
        if self.choices:
            return "[" + ", ".join(_choice_text(value, label) for value, label in self.choices) + "]"
        if self.minimum is not None or self.maximum is not None:
            parts = [self.minimum, self.step, self.maximum]
            return "[" + ":".join(f"{p:g}" for p in parts if p is not None) + "]"
        if self.max_length is not None:
            return f"at most {self.max_length} characters"
        return ""

    def check(self, value: Value) -> Value:
        """`value` converted to the default's type.

        Raises `TemplateError` when the type is wrong or the value is outside the limits.
        """
        value = self._typed(value)
        if self.choices and value not in [v for v, _ in self.choices]:
            raise TemplateError(f"{self.name}={value!r} is not one of {self.limits}")
        if self.max_length is not None and isinstance(value, str) and len(value) > self.max_length:
            raise TemplateError(
                f"{self.name} has {len(value)} characters, limit {self.max_length}: shorten it"
            )
        for number in value if isinstance(value, tuple) else (value,):
            self._check_range(number)
        return value

    def _check_range(self, number: Value) -> None:
        if isinstance(number, bool) or not isinstance(number, int | float):
            return
        if number != number or number in (float("inf"), float("-inf")):
            raise TemplateError(
                f"{self.name}={number} is not a finite number: give a value of {self.limits or 'mm'}"
            )
        below = self.minimum is not None and number < self.minimum
        above = self.maximum is not None and number > self.maximum
        if below or above:
            raise TemplateError(f"{self.name}={number:g} is outside {self.limits}: choose a value within")

    def _typed(self, value: Value) -> Value:
        default = self.default
        wanted = type(default).__name__
        if default is None or value is None:
            if default is not None:
                raise TemplateError(f"{self.name} needs a {wanted}, got nothing")
            return value
        if isinstance(default, bool):
            if isinstance(value, bool):
                return value
        elif isinstance(default, int | float):
            if isinstance(value, int | float) and not isinstance(value, bool):
                whole = isinstance(default, int) and float(value).is_integer() and self._whole_steps()
                return int(value) if whole else float(value)
        elif isinstance(default, tuple):
            if isinstance(value, tuple) and len(value) == len(default):
                return value
        elif isinstance(value, bool | int | float):
            return f"{value}"
        elif isinstance(value, str):
            return value
        raise TemplateError(f"{self.name}={value!r} is not a {wanted}: the default is {default!r}")

    def _whole_steps(self) -> bool:
        return self.step is None or float(self.step).is_integer()


def parameters(source: str, tree: ast.Module) -> tuple[Parameter, ...]:
    """The parameters that stand on top of a template's source, in its order; `tree` is the source parsed."""
    comments, lines = _comments(source), source.splitlines()
    found = (_parameter(node, comments, lines) for node in tree.body)
    return tuple(parameter for parameter in found if parameter is not None)


def python_name(name: str) -> str:
    """A parameter's name in the template's own file."""
    return f"{name}_" if keyword.iskeyword(name) else name


def read_value(text: str) -> Value:
    """A literal as OpenSCAD or Python writes it; anything else is the string itself."""
    text = text.strip()
    words: dict[str, Value] = {"true": True, "false": False, "undef": None, "none": None}
    if text.lower() in words:
        return words[text.lower()]
    try:
        value = ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text
    if isinstance(value, list | tuple):
        return tuple(value)
    return value if isinstance(value, bool | int | float | str) else text


def _comments(source: str) -> dict[int, str]:
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return {t.start[0]: t.string.lstrip("#").strip() for t in tokens if t.type == tokenize.COMMENT}


def _parameter(node: ast.stmt, comments: Mapping[int, str], lines: list[str]) -> Parameter | None:
    if (
        not isinstance(node, ast.Assign)
        or len(node.targets) != 1
        or not isinstance(node.targets[0], ast.Name)
    ):
        return None
    name = node.targets[0].id
    if name.startswith("_") or name.isupper():
        return None
    try:
        default = ast.literal_eval(node.value)
    except ValueError:
        return None
    if isinstance(default, list):
        default = tuple(default)
    group = _group_above(node.lineno, comments, lines)
    if group == "Hidden":
        return None
    limits = _limits(comments.get(node.end_lineno or node.lineno, ""), default)
    return Parameter(
        _public_name(name), default, _description_above(node.lineno, comments, lines), group, **limits
    )


def _own_line_comment(number: int, comments: Mapping[int, str], lines: list[str]) -> str | None:
    if number in comments and lines[number - 1].lstrip().startswith("#"):
        return comments[number]
    return None


def _description_above(line: int, comments: Mapping[int, str], lines: list[str]) -> str:
    text = _own_line_comment(line - 1, comments, lines)
    return "" if text is None or _group_name(text) else text


def _group_above(line: int, comments: Mapping[int, str], lines: list[str]) -> str:
    for number in range(line - 1, 0, -1):
        text = _own_line_comment(number, comments, lines)
        if text and (name := _group_name(text)):
            return name
    return "Parameters"


def _group_name(comment: str) -> str | None:
    match = re.fullmatch(r"\[\s*([^\[\]:,]+?)\s*\]", comment)
    return match.group(1) if match else None


def _limits(comment: str, default: Value) -> dict[str, Any]:
    """OpenSCAD customizer widgets as keyword arguments of `Parameter`."""
    bracket = re.match(r"\[(.*)\]", comment)
    numeric = isinstance(default, int | float | tuple) and not isinstance(default, bool)
    if bracket is None:
        number = re.match(r"\d+(\.\d+)?\b", comment)
        if number is None:
            return {}
        return {"step": float(number.group())} if numeric else {"max_length": int(float(number.group()))}
    inside = bracket.group(1)
    if numeric and "," not in inside:
        return _range(inside)
    return {"choices": tuple(_choice(item, default) for item in inside.split(","))}


def _range(text: str) -> dict[str, float]:
    """`max`, `min:max` or `min:step:max`; nothing where it is no range, as OpenSCAD has it."""
    keys = {1: ("maximum",), 2: ("minimum", "maximum"), 3: ("minimum", "step", "maximum")}
    numbers = [read_value(part) for part in text.split(":")]
    if len(numbers) not in keys:
        return {}
    plain = [float(n) for n in numbers if isinstance(n, int | float) and not isinstance(n, bool)]
    return dict(zip(keys[len(numbers)], plain, strict=True)) if len(plain) == len(numbers) else {}


def _choice(item: str, default: Value) -> tuple[Value, str]:
    text, _, label = item.strip().partition(":")
    value: Value = text.strip() if isinstance(default, str) else read_value(text)
    return value, label.strip() or text.strip()


def _choice_text(value: Value, label: str) -> str:
    return str(value) if str(value) == label else f"{value}:{label}"


def _public_name(name: str) -> str:
    bare = name[:-1]
    return bare if name.endswith("_") and keyword.iskeyword(bare) else name
