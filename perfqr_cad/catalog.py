"""Templates: parametric parts that a user can list, set and run without writing code.

A template is a Python file whose top holds plain literal parameters with OpenSCAD customizer comments,
followed by `build(p)`, which gets the values as attributes of `p` and returns a `Design`:

    \"\"\"A flat plate with a perforated code.\"\"\"
    # [Code]
    # edge of the whole code with its quiet zone, mm
    size = 60  # [20:1:200]

    def build(p):
        return make(text=p.text, size_mm=p.size)

The comment behind a value is OpenSCAD's: `[max]`, `[min:max]`, `[min:step:max]`, `[a, b, c]`,
`[a:Label, b:Label]`, or a bare number (step of a number, longest length of a string). The comment above
a value describes it; `# [Tab]` starts a group, and the group `Hidden` is not listed. A name that is a
Python keyword carries a trailing underscore in the file only: `-D yield=40` sets `yield_`.

Order of precedence: defaults < parameter set (`-p FILE -P NAME`) < `-D name=value`. OpenSCAD itself lets
a set beat `-D`; here the more explicit wins.
"""

from __future__ import annotations

import ast
import difflib
import io
import json
import keyword
import re
import runpy
import tokenize
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from perfqr_cad.errors import TemplateError
from perfqr_cad.table import Table

Value = bool | int | float | str | tuple[float, ...] | None

_HERE = Path(__file__).resolve().parent
# In a checkout the templates are beside the package, in an installed wheel inside it.
TEMPLATE_FOLDERS = (_HERE.parent / "templates", _HERE / "templates")


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


@dataclass(frozen=True)
class Template:
    """A template file as read, not yet run."""

    name: str
    path: Path
    description: str
    parameters: tuple[Parameter, ...]

    def values(self, overrides: Mapping[str, Value]) -> dict[str, Value]:
        """All parameters with `overrides` checked and applied.

        Raises `TemplateError` naming the nearest known parameter when a name is unknown.
        """
        known = {p.name: p for p in self.parameters}
        result = {p.name: p.default for p in self.parameters}
        for name, value in overrides.items():
            if name not in known:
                near = difflib.get_close_matches(name, known, n=1)
                hint = f"; did you mean {near[0]!r}?" if near else f"; it has {', '.join(known)}"
                raise TemplateError(f"template {self.name!r} has no parameter {name!r}{hint}")
            result[name] = known[name].check(value)
        return result

    def build(self, overrides: Mapping[str, Value] | None = None) -> Any:
        """Run the template's `build(p)` and return its `Design`."""
        values = self.values(overrides or {})
        names = {_python_name(name): value for name, value in values.items()}
        function = runpy.run_path(str(self.path), run_name=f"perfqr_template_{self.name}").get("build")
        if not callable(function):
            raise TemplateError(f"{self.path.name} defines no build(p): add a function that returns a Design")
        return function(SimpleNamespace(**names))


def find(name: str) -> Template:
    """The template of that name (shipped), or read from a path ending in `.py`.

    Raises `TemplateError` when there is none.
    """
    if name.endswith(".py"):
        return load(Path(name))
    for folder in TEMPLATE_FOLDERS:
        path = folder / f"{name.replace('-', '_')}.py"
        if path.is_file():
            return load(path)
    shipped = ", ".join(t.name for t in available())
    raise TemplateError(f"no template {name!r}: shipped are {shipped}; a file of your own must end in .py")


def available() -> tuple[Template, ...]:
    """The shipped templates, by name."""
    paths = {p.stem: p for folder in reversed(TEMPLATE_FOLDERS) for p in folder.glob("[!_]*.py")}
    return tuple(load(paths[stem]) for stem in sorted(paths))


def load(path: Path) -> Template:
    """Read a template's parameters from its source without running it."""
    try:
        source = path.read_text(encoding="utf-8")
        tree = ast.parse(source)
    except (OSError, UnicodeDecodeError) as error:
        raise TemplateError(f"cannot read template {path}: {error}") from error
    except SyntaxError as error:
        raise TemplateError(f"{path.name} line {error.lineno}: {error.msg}") from error
    comments = _comments(source)
    lines = source.splitlines()
    parameters = tuple(
        parameter for node in tree.body if (parameter := _parameter(node, comments, lines)) is not None
    )
    if not any(isinstance(node, ast.FunctionDef) and node.name == "build" for node in tree.body):
        raise TemplateError(f"{path.name} defines no build(p): add a function that returns a Design")
    description = (ast.get_docstring(tree) or "").strip()
    return Template(path.stem.replace("_", "-"), path, description, parameters)


def read_definition(text: str) -> tuple[str, Value]:
    """`name=value` of a `-D` option; values are OpenSCAD or Python literals, bare words are strings."""
    name, equals, value = text.partition("=")
    name = name.strip()
    if not equals or not name.isidentifier():
        raise TemplateError(f"-D {text!r} is not name=value")
    return name, read_value(value)


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


def read_parameter_set(path: Path, name: str) -> dict[str, Value]:
    """The set `name` of an OpenSCAD customizer JSON file (`parameterSets`)."""
    try:
        sets = json.loads(path.read_text(encoding="utf-8"))["parameterSets"]
    except OSError as error:
        raise TemplateError(f"cannot read parameter sets {path}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise TemplateError(
            f"{path.name} is no OpenSCAD parameter-set file: it needs a 'parameterSets' object"
        ) from error
    if not isinstance(sets, dict) or not isinstance(sets.get(name), dict):
        known = ", ".join(sets) if isinstance(sets, dict) else "none"
        raise TemplateError(f"{path.name} has no parameter set {name!r}: it has {known}")
    return {key: read_value(v) if isinstance(v, str) else v for key, v in sets[name].items()}


def merge(*layers: Mapping[str, Value]) -> dict[str, Value]:
    """Overrides in order of precedence, the last one first to be believed."""
    return {name: value for layer in layers for name, value in layer.items()}


def describe(template: Template) -> dict[str, Any]:
    """A template and its parameters as plain JSON values."""
    return {
        "name": template.name,
        "description": template.description,
        "parameters": [
            {
                "name": p.name,
                "default": p.default,
                "description": p.description,
                "group": p.group,
                "minimum": p.minimum,
                "step": p.step,
                "maximum": p.maximum,
                "choices": [{"value": value, "label": label} for value, label in p.choices],
                "max_length": p.max_length,
            }
            for p in template.parameters
        ],
    }


def listing(template: Template) -> Table:
    """A template's parameters as a table for people."""
    rows = [(p.group, p.name, str(p.default), p.limits, p.description) for p in template.parameters]
    return Table(template.name, ("group", "name", "default", "limits", "meaning"), tuple(rows))


# --- reading customizer comments -----------------------------------------------------------------


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
        numbers = [float(part) for part in inside.split(":")]
        keys = {1: ("maximum",), 2: ("minimum", "maximum"), 3: ("minimum", "step", "maximum")}[len(numbers)]
        return dict(zip(keys, numbers, strict=True))
    return {"choices": tuple(_choice(item, default) for item in inside.split(","))}


def _choice(item: str, default: Value) -> tuple[Value, str]:
    text, _, label = item.strip().partition(":")
    value: Value = text.strip() if isinstance(default, str) else read_value(text)
    return value, label.strip() or text.strip()


def _choice_text(value: Value, label: str) -> str:
    return str(value) if str(value) == label else f"{value}:{label}"


def _public_name(name: str) -> str:
    bare = name[:-1]
    return bare if name.endswith("_") and keyword.iskeyword(bare) else name


def _python_name(name: str) -> str:
    return f"{name}_" if keyword.iskeyword(name) else name
