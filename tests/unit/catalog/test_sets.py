"""Definitions and parameter sets: the kind of a parameter decides how a value is read."""

import json
from pathlib import Path

import pytest

from perfqr_cad import catalog
from perfqr_cad.errors import TemplateError

SOURCE = '''
"""A tag whose texts look like numbers."""
# which bench
bench = "A"  # [A:bench A, 1:bench 1, 02:bench 02]
serial = "007"
width = 40
edge = 1.5  # [0:0.5:10]
flag = False
short = "ab"  # 8
at = [1.0, 2.0]


def build(p):
    return None
'''


@pytest.fixture
def tag(tmp_path: Path) -> catalog.Template:
    path = tmp_path / "tag.py"
    path.write_text(SOURCE)
    return catalog.find(str(path))


def set_file(folder: Path, entries: object, *, encoding: str = "utf-8") -> Path:
    path = folder / "sets.json"
    text = json.dumps({"parameterSets": {"s": entries}, "fileFormatVersion": "1"})
    path.write_text(text, encoding=encoding)
    return path


@pytest.mark.parametrize(
    "text",
    [
        "1.50",
        "12E3",
        "1_000",
        "0x1F",
        "+42",
        "00.5",
        "true",
        " hi ",
        "None",
        "undef",
        "[1, 2]",
        '"x"',
        "1e5",
        "a=b",
    ],
)
def test_a_text_stays_letter_by_letter(tag: catalog.Template, text: str, tmp_path: Path) -> None:
    assert tag.values(catalog.read_definitions([f"serial={text}"]))["serial"] == text
    read = catalog.read_parameter_set(set_file(tmp_path, {"serial": text}), "s")
    assert tag.values(read)["serial"] == text


def test_openscad_writes_every_value_as_a_string(tag: catalog.Template, tmp_path: Path) -> None:
    written = {
        "width": "40.5",
        "edge": "2",
        "flag": "true",
        "short": 'a "b" \\',
        "at": "[3, 4]",
        "bench": "02",
    }
    values = tag.values(catalog.read_parameter_set(set_file(tmp_path, written), "s"))
    assert values == {
        "bench": "02", "serial": "007", "width": 40.5, "edge": 2.0, "flag": True, "short": 'a "b" \\',
        "at": (3.0, 4.0),
    }  # fmt: skip


def test_json_values_are_read_by_kind_too(tag: catalog.Template, tmp_path: Path) -> None:
    path = tmp_path / "sets.json"
    path.write_text('{"parameterSets": {"s": {"serial": 1.50, "width": 41, "flag": true, "at": [5, 6]}}}')
    values = tag.values(catalog.read_parameter_set(path, "s"))
    assert (values["serial"], values["width"], values["flag"], values["at"]) == ("1.50", 41, True, (5, 6))


def test_a_byte_order_mark_is_no_fault(tag: catalog.Template, tmp_path: Path) -> None:
    path = set_file(tmp_path, {"width": "7"}, encoding="utf-8-sig")
    assert tag.values(catalog.read_parameter_set(path, "s"))["width"] == 7
    marked = tmp_path / "marked.py"
    marked.write_text(SOURCE, encoding="utf-8-sig")
    assert catalog.load(marked).parameters == tag.parameters


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        ("at", [5], "at=[5] is no vector of 2 numbers"),
        ("at", [[5], 6], "is no vector of 2 numbers"),
        ("at", {"x": 1}, "is no vector of 2 numbers"),
        ("at", "5", "is no vector of 2 numbers"),
        ("at", [True, 1], "is no vector of 2 numbers"),
        ("width", "wide", "width='wide' is no number"),
        ("width", "1_000", "is no number"),
        ("width", "0x1F", "is no number"),
        ("width", "٣", "is no number"),
        ("width", True, "is no number"),
        ("width", [1], "is no number"),
        ("width", None, "width needs a value"),
        ("edge", "1" + "0" * 400, "edge=inf is not a finite number"),
        ("edge", int("9" * 400), "not a finite number"),
        ("flag", "yes", "is neither true nor false"),
        ("flag", 1, "is neither true nor false"),
        ("serial", [1], "is no text"),
        ("bench", "1.0", "is not one of A, 1, 02"),
        ("serial", "\ud800", "is no text"),
    ],
)
def test_a_value_of_another_kind(
    tag: catalog.Template, name: str, given: object, says: str, tmp_path: Path
) -> None:
    with pytest.raises(TemplateError) as told:
        tag.values(catalog.read_parameter_set(set_file(tmp_path, {name: given}), "s"))
    assert says in str(told.value)
    assert not any(word in str(told.value) for word in ("tuple", "None", "True", "float", "dict"))


@pytest.mark.parametrize("depth", [5, 500, 100_000])
def test_deep_json_is_refused(tag: catalog.Template, depth: int, tmp_path: Path) -> None:
    path = tmp_path / "deep.json"
    path.write_text('{"parameterSets": {"s": {"at": ' + "[" * depth + "]" * depth + "}}}")
    with pytest.raises(TemplateError):
        tag.values(catalog.read_parameter_set(path, "s"))


@pytest.mark.parametrize(
    "text",
    ["{", "[]", "3", '{"parameterSets": 3}', '{"parameterSets": {"s": {"x": NaN}}}', "\x00", "9" * 5000],
)
def test_a_file_without_parameter_sets(text: str, tmp_path: Path) -> None:
    path = tmp_path / "sets.json"
    path.write_text(text)
    with pytest.raises(TemplateError, match=r"no OpenSCAD parameter-set file|is no JSON"):
        catalog.read_parameter_set(path, "s")


def test_files_that_are_none(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.json", tmp_path / ("n" * 300), Path("/dev/zero")):
        with pytest.raises(TemplateError, match="a file of parameter sets"):
            catalog.read_parameter_set(path, "s")
    huge = tmp_path / "huge.json"
    huge.write_bytes(b" " * 2_000_001)
    with pytest.raises(TemplateError, match="a file of parameter sets"):
        catalog.read_parameter_set(huge, "s")


def test_two_definitions_of_one_name() -> None:
    assert catalog.read_definitions(["a=1", "b=2", "a=1"]) == {"a": "1", "b": "2"}
    with pytest.raises(TemplateError, match="a is given twice, '1' and '2'"):
        catalog.read_definitions(["a=1", "a=2"])
