"""What can be set, for people and programs: a table, plain values, JSON Schema, docs/settings.md."""

from __future__ import annotations

from typing import Any

from perfqr_cad.catalog.templates import Template
from perfqr_cad.pipeline.kinds import shown
from perfqr_cad.pipeline.parameter import Parameter
from perfqr_cad.pipeline.request import SETTINGS
from perfqr_cad.pipeline.setting import GROUPS
from perfqr_cad.table import Table

_PAGE = """# Settings

Made from the declarations in `perfqr_cad/pipeline/request.py` by `python docs/settings.py`.

A setting has one name: `size_mm` in Python, `--size` on the command line, `size` in a template and with `-D`
differ by the unit alone. "Not given" is `None` in Python and an empty value elsewhere; the number in brackets
stands for it, too. A setting that needs another, or a file of some kind, is refused without it. A template
takes in the groups that it names: `# [Shared: Code, Look]`.
"""


def describe(template: Template) -> dict[str, Any]:
    """A template and its parameters as plain JSON values."""
    return {
        "name": template.name,
        "description": template.description,
        "parameters": [
            {
                "name": p.name,
                "default": p.default,
                "kind": p.kind.value,
                "description": p.description,
                "group": p.group,
                "unit": p.unit,
                "minimum": p.minimum,
                "step": p.step,
                "maximum": p.maximum,
                "choices": [{"value": value, "label": label} for value, label in p.choices],
                "max_length": p.max_length,
                "not_given": p.empty,
            }
            for p in template.parameters
        ],
    }


def schema(template: Template) -> dict[str, Any]:
    """The parameters of a template as a JSON Schema (draft 2020-12) of one object."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": template.name,
        "description": template.description,
        "type": "object",
        "properties": {p.name: p.schema() for p in template.parameters},
        "additionalProperties": False,
    }


def listing(template: Template) -> Table:
    """A template's parameters as a table for people."""
    rows = [
        (p.group, p.name, _default(p), p.unit or None, p.limits or None, p.meaning)
        for p in template.parameters
    ]
    return Table(template.name, ("group", "name", "default", "unit", "limits", "meaning"), tuple(rows))


def page() -> str:
    """docs/settings.md."""
    parts = [_PAGE]
    for group in GROUPS:
        parts.append(f"## {group}\n\n| option | Python | default | range | meaning |\n|---|---|---|---|---|")
        parts += [_row(declared) for declared in SETTINGS if declared.group == group]
        parts.append("")
    return "\n".join(parts)


def _row(declared: Parameter) -> str:
    stands_for_it = "" if declared.left_open is None else f" [{declared.left_open:g}]"
    not_given = "" if not declared.empty else f"; not given{stands_for_it}: {declared.empty}"
    cells = (
        f"`{declared.option}`",
        f"`{declared.field}`",
        _default(declared) or "not given",
        declared.wanted,
        f"{declared.description}{not_given}{_needs(declared)}",
    )
    return f"| {' | '.join(cells)} |"


def _needs(declared: Parameter) -> str:
    return f"; needs {' or '.join(f'`{need}`' for need in declared.needs)}" if declared.needs else ""


def _default(declared: Parameter) -> str | None:
    return None if declared.default in (None, ()) else shown(declared.default).strip("'")
