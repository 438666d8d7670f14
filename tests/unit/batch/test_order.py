"""Values and names of rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from perfqr_cad import catalog
from perfqr_cad.batch import Label, Order, Plan, suffixes
from perfqr_cad.errors import DesignError, TemplateError


def plan(**changes: Any) -> Plan:
    fields: dict[str, Any] = {
        "template": catalog.find("plate"),
        "shared": {},
        "folder": Path("out"),
        "pattern": None,
        "suffixes": (".stl", ".json"),
        "timeout_s": 60.0,
    }
    return Plan(**fields | changes)


def order(of: Plan, *cells: dict[str, str]) -> Order:
    made = of.orders([Label(number, row) for number, row in enumerate(cells, 1)])[0]
    assert isinstance(made, Order)
    return made


def test_a_column_is_a_setting_and_name_names_files() -> None:
    made = order(plan(shared={"size": "40", "frame": "8"}), {"name": "A 1", "text": "x", "size": "50"})
    assert made.values == {"text": "x", "size": "50", "frame": "8"}
    assert made.outputs == ("out/A 1.stl", "out/A 1.json")


def test_rows_without_a_name_are_numbered_alike() -> None:
    rows = [Label(number, {"text": "x"}) for number in range(1, 12)]
    names = [one.name for one in plan().orders(rows) if isinstance(one, Order)]
    assert names == [f"{number:02}" for number in range(1, 12)]


def test_patterns_take_cells() -> None:
    of = plan(
        shared={"caption": "Nr. {serial}", "text": "https://example.com/{serial}"},
        pattern="tag-{row}-{serial}",
    )
    made = order(of, {"serial": "007"})
    assert made.name == "tag-1-007"
    assert made.values == {"caption": "Nr. 007", "text": "https://example.com/007"}
    assert order(plan(shared={"text": "{{{a}}}"}), {"a": "1"}).values["text"] == "{1}"


def test_a_rows_content_hides_the_shared_one() -> None:
    made = order(plan(shared={"text": "all", "size": "40"}), {"url": "example.com"})
    assert made.values == {"url": "example.com", "size": "40"}


@pytest.mark.parametrize(
    ("changes", "rows", "told"),
    [
        ({}, [{"txet": "a"}], "does not take 'txet'; did you mean 'text'"),
        ({"pattern": "{serial}"}, [{"text": "a"}], "{serial} names no column: the table has text"),
        ({"pattern": "{text"}, [{"text": "a"}], "write {column}"),
        ({"pattern": "{0.real}"}, [{"text": "a"}], "names no column"),
        ({"pattern": "same"}, [{"text": "a"}, {"text": "b"}], "rows 1 and 2 are both named 'same'"),
        ({}, [{"name": "A", "text": "a"}, {"name": "a", "text": "b"}], "both named 'a'"),
    ],
)
def test_faults_of_the_whole(changes: dict[str, Any], rows: list[dict[str, str]], told: str) -> None:
    with pytest.raises((DesignError, TemplateError), match=told.replace("{", r"\{")):
        plan(**changes).orders([Label(number, row) for number, row in enumerate(rows, 1)])


@pytest.mark.parametrize(
    "name", ["../../x", "a/b", "a\\b", "CON", "nul.txt", "com1", "a\nb", "a?", ".", " a", "a.", "x" * 121]
)
def test_a_name_that_is_none_is_the_rows_own_fault(name: str) -> None:
    (fault,) = plan().orders([Label(1, {"name": name, "text": "a"})])
    assert not isinstance(fault, Order)
    assert fault[1].startswith("name ")
    (sound,) = plan().orders([Label(1, {"name": "a.b-c_(1) ü", "text": "a"})])
    assert isinstance(sound, Order)


def test_a_key_tells_orders_apart() -> None:
    first = order(plan(), {"text": "a"})
    keys = {
        first.key(b""),
        first.key(b"#"),
        order(plan(), {"text": "b"}).key(b""),
        order(plan(suffixes=(".svg",)), {"text": "a"}).key(b""),
    }
    assert len(keys) == 4
    assert first.key(b"") == order(plan(), {"text": "a"}).key(b"")


def test_suffixes_are_known_formats() -> None:
    assert suffixes("STL") == (".stl", ".json")
    with pytest.raises(DesignError, match="unknown format"):
        suffixes("stl,doc")
