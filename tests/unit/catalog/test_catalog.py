"""Templates: reading customizer comments, precedence, and every refusal."""

import json
from pathlib import Path

import pytest

from perfqr_cad import catalog
from perfqr_cad.errors import PerfQRError, TemplateError

SOURCE = '''
"""A tag.

More about it."""

# [Code]
# what it says
text = "hello"  # 8
# how wide
size = 60  # [20:1:200]
ratio = 0.5  # [0:0.25:1]
style = "square"  # [square:Plain, dots]
count = 3  # [1, 2, 3:three]
pair = [1, 2]  # [0:10]
flag = True
yield_ = 40  # 0.5
# [Hidden]
secret = 7
LIMIT = 9


def build(p):
    return vars(p)
'''


@pytest.fixture
def tag(tmp_path: Path) -> catalog.Template:
    path = tmp_path / "my_tag.py"
    path.write_text(SOURCE)
    return catalog.find(str(path))


def test_parameters_are_read_without_running(tag: catalog.Template) -> None:
    by_name = {p.name: p for p in tag.parameters}
    assert tag.name == "my-tag"
    assert tag.description.splitlines()[0] == "A tag."
    assert list(by_name) == ["text", "size", "ratio", "style", "count", "pair", "flag", "yield"]
    assert (by_name["size"].minimum, by_name["size"].step, by_name["size"].maximum) == (20, 1, 200)
    assert by_name["size"].description == "how wide"
    assert by_name["size"].group == "Code"
    assert by_name["style"].choices == (("square", "Plain"), ("dots", "dots"))
    assert by_name["count"].choices == ((1, "1"), (2, "2"), (3, "three"))
    assert by_name["text"].max_length == 8
    assert by_name["yield"].step == 0.5


def test_build_gets_defaults_then_overrides(tag: catalog.Template) -> None:
    values = tag.build({"size": 70, "yield": 12.0, "flag": False, "pair": (3, 4)})
    assert values == {
        "text": "hello", "size": 70, "ratio": 0.5, "style": "square", "count": 3, "pair": (3, 4),
        "flag": False, "yield_": 12.0,
    }  # fmt: skip


def test_definition_beats_set_beats_default(tag: catalog.Template, tmp_path: Path) -> None:
    sets = tmp_path / "sets.json"
    sets.write_text(json.dumps({"parameterSets": {"small": {"size": "30", "flag": "false", "text": "12"}}}))
    chosen = catalog.merge(
        catalog.read_parameter_set(sets, "small"), dict([catalog.read_definition("size=40")])
    )
    values = tag.values(chosen)
    assert values["size"] == 40
    assert values["flag"] is False
    assert values["text"] == "12"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ({"size": 19}, "outside"),
        ({"size": float("nan")}, "finite"),
        ({"size": "wide"}, "not a int"),
        ({"siez": 30}, "did you mean 'size'"),
        ({"style": "stars"}, "not one of"),
        ({"pair": (1, 99)}, "outside"),
        ({"pair": (1, 2, 3)}, "not a tuple"),
        ({"flag": 2}, "not a bool"),
        ({"text": "far too long"}, "limit 8"),
        ({"size": None}, "got nothing"),
    ],
)
def test_bad_values_are_refused(
    tag: catalog.Template, override: dict[str, catalog.Value], message: str
) -> None:
    with pytest.raises(TemplateError, match=message):
        tag.values(override)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("3", 3),
        ("2.5", 2.5),
        ("true", True),
        ('"a b"', "a b"),
        ("bare", "bare"),
        ("[1, 2]", (1, 2)),
        ("a=b", "a=b"),
    ],
)
def test_values_read_as_openscad_writes_them(text: str, value: catalog.Value) -> None:
    assert catalog.read_definition(f"name={text}") == ("name", value)


@pytest.mark.parametrize("text", ["size", "=3", "2x=1"])
def test_malformed_definition(text: str) -> None:
    with pytest.raises(TemplateError, match="name=value"):
        catalog.read_definition(text)


def test_missing_sets_files_and_templates(tmp_path: Path) -> None:
    good = tmp_path / "sets.json"
    good.write_text('{"parameterSets": {"a": {}}}')
    broken = tmp_path / "broken.json"
    broken.write_text("{")
    with pytest.raises(TemplateError, match="it has a"):
        catalog.read_parameter_set(good, "b")
    with pytest.raises(TemplateError, match="no OpenSCAD parameter-set file"):
        catalog.read_parameter_set(broken, "a")
    with pytest.raises(TemplateError, match="cannot read"):
        catalog.read_parameter_set(tmp_path / "none.json", "a")
    with pytest.raises(TemplateError, match="shipped are"):
        catalog.find("nothing")
    with pytest.raises(TemplateError, match="cannot read"):
        catalog.find(str(tmp_path / "none.py"))


def test_a_file_without_build_or_with_bad_syntax(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text("size = 3\n")
    with pytest.raises(TemplateError, match="no build"):
        catalog.load(path)
    path.write_text("size = (\n")
    with pytest.raises(TemplateError, match="line 1"):
        catalog.load(path)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return 1 / p.size", "t.py line 4: ZeroDivisionError"),
        ("pass", "returns nothing"),
        ("raise DesignError('too small')", "too small"),
    ],
)
def test_what_a_template_gets_wrong_is_told(tmp_path: Path, body: str, message: str) -> None:
    path = tmp_path / "t.py"
    path.write_text(f"from perfqr_cad.errors import DesignError\nsize = 0\ndef build(p):\n    {body}\n")
    with pytest.raises(PerfQRError, match=message):
        catalog.find(str(path)).build()


def test_comments_that_are_no_limits(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text("a = 1  # [mm]\nb = 2  # [1:2:3:4]\nc = 3  # [1:x]\ndef build(p): return p\n")
    assert [p.limits for p in catalog.load(path).parameters] == ["", "", ""]


def test_every_shipped_template_describes_itself() -> None:
    shipped = catalog.available()
    assert "plate" in [t.name for t in shipped]
    for template in shipped:
        assert template.description
        assert template.parameters
        template.values({})
        listed = catalog.describe(template)["parameters"]
        assert [p["name"] for p in listed] == [p.name for p in template.parameters]
