"""Templates: reading customizer comments, precedence, and every refusal."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from perfqr_cad import catalog, settings
from perfqr_cad.errors import TemplateError
from perfqr_cad.pipeline.request import SETTINGS, Request

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
    return None
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


def test_values_are_defaults_then_overrides(tag: catalog.Template) -> None:
    assert tag.values({"size": 70, "yield": 12.0, "flag": False, "pair": (3, 4)}) == {
        "text": "hello", "size": 70, "ratio": 0.5, "style": "square", "count": 3, "pair": (3, 4),
        "flag": False, "yield": 12.0,
    }  # fmt: skip


def test_whole_defaults_keep_whole_numbers_and_take_decimals(tag: catalog.Template) -> None:
    values = [tag.values({"size": letters})["size"] for letters in ("30", "30.0", "30.5")]
    assert [(v, type(v)) for v in values] == [(30, int), (30, int), (30.5, float)]
    assert isinstance(tag.values({"count": "2"})["count"], int)


def test_definition_beats_set_beats_default(tag: catalog.Template, tmp_path: Path) -> None:
    sets = tmp_path / "sets.json"
    sets.write_text(json.dumps({"parameterSets": {"small": {"size": "30", "flag": "false", "text": "12"}}}))
    chosen = catalog.read_parameter_set(sets, "small") | catalog.read_definitions(["size=40"])
    values = tag.values(chosen)
    assert values["size"] == 40
    assert values["flag"] is False
    assert values["text"] == "12"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ({"size": 19}, "outside"),
        ({"size": float("nan")}, "finite"),
        ({"size": "wide"}, "is no number: give 20 to 200"),
        ({"siez": 30}, "did you mean 'size'"),
        ({"style": "stars"}, "not one of"),
        ({"pair": (1, 99)}, "outside"),
        ({"pair": (1, 2, 3)}, "is no vector of 2 numbers"),
        ({"flag": 2}, "is neither true nor false"),
        ({"text": "far too long"}, "limit 8"),
        ({"size": None}, "needs a value"),
    ],
)
def test_bad_values_are_refused(
    tag: catalog.Template, override: dict[str, catalog.Value], message: str
) -> None:
    with pytest.raises(TemplateError, match=message):
        tag.values(override)


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
    with pytest.raises(TemplateError, match="is no JSON"):
        catalog.read_parameter_set(broken, "a")
    with pytest.raises(TemplateError, match="cannot be read"):
        catalog.read_parameter_set(tmp_path / "none.json", "a")
    with pytest.raises(TemplateError, match="shipped are"):
        catalog.find("nothing")
    with pytest.raises(TemplateError, match="cannot be read"):
        catalog.find(str(tmp_path / "none.py"))


def test_a_file_without_build_or_with_bad_syntax(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text("size = 3\n")
    with pytest.raises(TemplateError, match="no build"):
        catalog.load(path)
    path.write_text("size = (\n")
    with pytest.raises(TemplateError, match="line 1"):
        catalog.load(path)


def test_comments_that_are_no_limits(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text("a = 1  # [mm]\nb = 2  # [1:2:3:4]\nc = 3  # [1:x]\ndef build(p): return p\n")
    assert [p.limits for p in catalog.load(path).parameters] == ["", "", ""]


def test_an_annotation_gives_the_kind(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text(
        "at: tuple[float, float] | None = None\nname: str | None = None\ndef build(p): return p\n"
    )
    tag = catalog.load(path)
    assert tag.values({"at": "[1, 2]", "name": "[1, 2]"}) == {"at": (1, 2), "name": "[1, 2]"}
    assert tag.values({"at": "", "name": ""}) == {"at": None, "name": None}
    with pytest.raises(TemplateError, match="no vector of 2 numbers"):
        tag.values({"at": "3"})


def test_a_default_without_a_kind_is_read_as_it_looks(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text("it = None\ndef build(p): return p\n")
    tag = catalog.load(path)
    read = {letters: tag.values({"it": letters})["it"] for letters in ("[1, 2]", "3", "2.5", "true", "a, b")}
    assert read == {"[1, 2]": (1, 2), "3": 3, "2.5": 2.5, "true": True, "a, b": "a, b"}


def test_groups_of_settings_are_taken_in_by_one_line(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text(
        "# [Shared: Code, Proof]\n# how large\nsize = 30  # [10:50]\n# [Own]\nmine = 1\n"
        "def build(p): return p\n"
    )
    by_name = {p.name: p for p in catalog.load(path).parameters}
    assert list(by_name)[-1] == "mine"
    assert {p.group for p in by_name.values()} == {"Code", "Proof", "Own"}
    size = by_name["size"]
    assert (size.default, size.minimum, size.maximum, size.unit) == (30, 10, 50, "mm")
    assert size.description == "how large"
    with pytest.raises(TemplateError, match="outside 10 to 50 mm"):
        catalog.load(path).values({"size": "0"})


def test_all_groups_and_an_unknown_one(tmp_path: Path) -> None:
    path = tmp_path / "t.py"
    path.write_text("# [Shared]\ndef build(p): return p\n")
    assert [p.name for p in catalog.load(path).parameters] == [s.name for s in SETTINGS]
    path.write_text("# [Shared: Colours]\ndef build(p): return p\n")
    with pytest.raises(TemplateError, match="no shared group 'Colours'"):
        catalog.load(path)


def test_a_template_that_lists_settings_by_itself_hands_them_on() -> None:
    """The style without `[Shared]`: each a literal, 0, -1 and nothing for what the program chooses."""
    literals = SimpleNamespace(
        text="A", image="", version=0, size=0, fillet=-1, draft=-1, lip=-1, depth=0, caption="", yield_=0,
        scan_tilt=0, hole="3; 0,35,4", thickness=2, own=1,
    )  # fmt: skip
    handed = settings(literals)
    assert handed == {
        "text": "A", "image": None, "version": None, "size_mm": None, "fillet_mm": None, "draft_deg": None,
        "lip_mm": None, "depth_mm": None, "caption": None, "yield_mpa": None, "scan_tilt_deg": None,
        "hole_mm": ((3,), (0, 35, 4)), "thickness_mm": 2,
    }  # fmt: skip
    assert Request(**handed).thickness_mm == 2
    literals.image = "code.png"
    assert settings(literals)["text"] is None


def test_every_shipped_template_describes_itself() -> None:
    shipped = catalog.available()
    assert "plate" in [t.name for t in shipped]
    for template in shipped:
        assert template.description
        assert template.parameters
        template.values({})
        listed = catalog.describe(template)["parameters"]
        assert [p["name"] for p in listed] == [p.name for p in template.parameters]
