"""Templates: parametric parts that a user can list, set and run without writing code.

A template is a Python file whose top declares parameters (`catalog.customizer`), followed by `build(p)`,
which gets the values as attributes of `p` and returns a `Design`:

    \"\"\"A tag of two sizes.\"\"\"
    from perfqr_cad import make, settings

    # [Shared: Code, Look]
    # [Tag]
    # how large
    large = False

    def build(p):
        return make(**settings(p), thickness_mm=3 if p.large else 2)

Order of precedence: defaults < parameter set (`-p FILE -P NAME`) < `-D name=value` and options. OpenSCAD
itself lets a set beat `-D`; here the more explicit wins.
"""

from __future__ import annotations

import ast
import difflib
import tokenize
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from perfqr_cad.bounded import read_text
from perfqr_cad.catalog.customizer import parameters
from perfqr_cad.catalog.running import TIMEOUT_S, run
from perfqr_cad.errors import DesignError, TemplateError
from perfqr_cad.pipeline.kinds import Value, shown
from perfqr_cad.pipeline.parameter import Parameter

if TYPE_CHECKING:
    from perfqr_cad.pipeline.design import Design

_HERE = Path(__file__).resolve().parents[1]
# An installed wheel has the templates inside the package, a checkout beside it.
SHIPPED = next(
    (f for f in (_HERE / "templates", _HERE.parent / "templates") if f.is_dir()), _HERE / "templates"
)
MOST_BYTES = 1_000_000  # of a template's source


@dataclass(frozen=True)
class Template:
    """A template file as read, not yet run."""

    name: str
    path: Path
    description: str
    parameters: tuple[Parameter, ...]

    def values(self, overrides: Mapping[str, Any]) -> dict[str, Value]:
        """All parameters with `overrides` read, checked and applied.

        Raises `TemplateError` for a value that is none of its parameter's, and for an unknown name with the
        nearest one that is known.
        """
        result = {p.name: p.default for p in self.parameters}
        for name, given in overrides.items():
            declared = self.parameter(name)
            try:
                result[name] = declared.read(given)
            except DesignError as error:
                raise TemplateError(str(error)) from error
        return result

    def parameter(self, name: str) -> Parameter:
        """The parameter of that name. Raises `TemplateError` with the nearest one where there is none."""
        for declared in self.parameters:
            if declared.name == name:
                return declared
        raise TemplateError(f"template {self.name!r} does not take {shown(name)}{self._near(name)}")

    def build(self, overrides: Mapping[str, Any] | None = None, *, timeout_s: float = TIMEOUT_S) -> Design:
        """Run the template's `build(p)` and return its `Design`.

        timeout_s   seconds that the template's own code may compute, or wait in one go

        Raises `TemplateError` with the line where the template's own code fails, when it returns no design,
        ends the program or takes too long.
        """
        values = self.values(overrides or {})
        names = {p.python_name: values[p.name] for p in self.parameters}
        return run(self.path, names, timeout_s)

    def _near(self, name: str) -> str:
        near = difflib.get_close_matches(name, [p.name for p in self.parameters], n=1)
        return (
            f"; did you mean {near[0]!r}?" if near else f": `perfqr params {self.name}` lists what it takes"
        )


def find(name: str) -> Template:
    """The template of that name (shipped), or read from a path ending in `.py`.

    Raises `TemplateError` when there is none.
    """
    if name.endswith(".py"):
        return load(Path(name))
    shipped = {template.stem.replace("_", "-"): template for template in _shipped()}
    if name.replace("_", "-") in shipped:
        return load(shipped[name.replace("_", "-")])
    known = ", ".join(shipped)
    raise TemplateError(f"no template {shown(name)}: shipped are {known}; a file of your own must end in .py")


def available() -> tuple[Template, ...]:
    """The shipped templates, by name."""
    return tuple(load(path) for path in _shipped())


def load(path: Path) -> Template:
    """Read a template's parameters from its source without running it."""
    source = read_text(path, MOST_BYTES, TemplateError, "a template (.py)")
    try:
        tree = ast.parse(source)
        declared = parameters(source, tree)
    except (SyntaxError, tokenize.TokenError) as error:
        at = f" line {error.lineno}" if isinstance(error, SyntaxError) else ""
        raise TemplateError(f"{path.name}{at}: {error}") from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise TemplateError(f"{path.name} is nested too deeply, or no Python: simplify it") from error
    except DesignError as error:
        raise TemplateError(f"{path.name}: {error}") from error
    build = next((n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == "build"), None)
    if build is None:
        raise TemplateError(f"{path.name} defines no build(p): add a function that returns a Design")
    if not (build.args.posonlyargs or build.args.args or build.args.vararg):
        raise TemplateError(f"{path.name}: build() takes no values: write def build(p)")
    description = (ast.get_docstring(tree) or "").strip()
    return Template(path.stem.replace("_", "-"), path, description, declared)


def _shipped() -> list[Path]:
    return sorted(SHIPPED.glob("[!_]*.py"))
