"""The lists made from declarations: the page in docs, the JSON Schema, the table, plain values."""

from pathlib import Path

import pytest

from perfqr_cad import catalog
from perfqr_cad.catalog.reference import page
from perfqr_cad.pipeline.request import SETTINGS

PAGE = Path(__file__).parents[3] / "docs" / "settings.md"
ENTRIES = {
    "string": str,
    "boolean": bool,
    "integer": int,
    "number": float,
    "array": tuple,
    "null": type(None),
}


def test_the_page_in_docs_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run: python docs/settings.py"


def test_the_page_names_every_setting() -> None:
    text = page()
    for declared in SETTINGS:
        assert f"| `{declared.option}` | `{declared.field}` |" in text


@pytest.mark.parametrize("template", catalog.available(), ids=lambda template: template.name)
def test_defaults_are_what_the_schema_allows(template: catalog.Template) -> None:
    schema = catalog.schema(template)
    assert set(schema["properties"]) == {p.name for p in template.parameters}
    assert schema["additionalProperties"] is False
    for name, declared in schema["properties"].items():
        default, kinds = declared["default"], declared.get("type", list(ENTRIES))
        kinds = [kinds] if isinstance(kinds, str) else kinds
        assert isinstance(default, (int, *(ENTRIES[kind] for kind in kinds))), name
        if isinstance(default, int | float) and not isinstance(default, bool):
            assert declared.get("minimum", default) <= default <= declared.get("maximum", default)
        assert default in declared.get("enum", [default])


@pytest.mark.parametrize("template", catalog.available(), ids=lambda template: template.name)
def test_every_shipped_template_describes_itself(template: catalog.Template) -> None:
    assert template.description
    template.values({})
    listed = catalog.describe(template)["parameters"]
    assert [p["name"] for p in listed] == [p.name for p in template.parameters]
    assert {"text", "size", "style", "nozzle", "support", "seed"} <= {p["name"] for p in listed}
    assert len(template.path.read_text().splitlines()) <= 40
    assert len(catalog.listing(template).rows) == len(listed)


def test_the_plate_takes_every_setting() -> None:
    assert {p.name for p in catalog.find("plate").parameters} == {s.name for s in SETTINGS}
