"""Templates: parametric parts that a user can list, set and run without writing code.

A template is a Python file whose top holds plain literal parameters with OpenSCAD customizer comments,
followed by `build(p)`, which gets the values as attributes of `p` and returns a `Design`:

    \"\"\"A flat plate with a perforated code.\"\"\"
    # [Code]
    # edge of the whole code with its quiet zone, mm
    size = 60  # [20:1:200]

    def build(p):
        return make(text=p.text, size_mm=p.size)

Order of precedence: defaults < parameter set (`-p FILE -P NAME`) < `-D name=value`. OpenSCAD itself lets
a set beat `-D`; here the more explicit wins.
"""

from __future__ import annotations

import ast
import difflib
import json
import runpy
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from perfqr_cad.catalog.parameter import Parameter, Value, parameters, python_name, read_value
from perfqr_cad.errors import PerfQRError, TemplateError
from perfqr_cad.table import Table

_HERE = Path(__file__).resolve().parents[1]
# In a checkout the templates are beside the package, in an installed wheel inside it.
TEMPLATE_FOLDERS = (_HERE.parent / "templates", _HERE / "templates")


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
        """Run the template's `build(p)` and return its `Design`.

        Raises `TemplateError` with the line where the template's own code fails, or when it returns nothing.
        """
        values = self.values(overrides or {})
        names = {python_name(name): value for name, value in values.items()}
        try:
            build = runpy.run_path(str(self.path), run_name=f"perfqr_template_{self.name}")["build"]
            made = build(SimpleNamespace(**names))
        except Exception as error:
            innermost = traceback.extract_tb(error.__traceback__)[-1]
            if isinstance(error, PerfQRError) or innermost.filename != str(self.path):
                raise
            raise TemplateError(
                f"{self.path.name} line {innermost.lineno}: {type(error).__name__}: {error}"
            ) from error
        if made is None:
            raise TemplateError(f"build(p) of {self.path.name} returns nothing: return a Design")
        return made


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
    if not any(isinstance(node, ast.FunctionDef) and node.name == "build" for node in tree.body):
        raise TemplateError(f"{path.name} defines no build(p): add a function that returns a Design")
    description = (ast.get_docstring(tree) or "").strip()
    return Template(path.stem.replace("_", "-"), path, description, parameters(source, tree))


def read_definition(text: str) -> tuple[str, Value]:
    """`name=value` of a `-D` option; values are OpenSCAD or Python literals, bare words are strings."""
    name, equals, value = text.partition("=")
    name = name.strip()
    if not equals or not name.isidentifier():
        raise TemplateError(f"-D {text!r} is not name=value")
    return name, read_value(value)


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
