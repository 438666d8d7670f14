"""The command line: bad input is one line on standard error, exit 2, and nothing half-written."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import segno
from PIL import Image

from perfqr_cad.cli import main
from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.request import SETTINGS
from perfqr_cad.pipeline.setting import GROUPS

Run = Callable[..., tuple[int, str, str]]
Refused = Callable[..., str]
TEXT = "https://example.com/p/1234567"


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str]) -> Run:
    def call(*arguments: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as stop:
            main([str(a) for a in arguments])
        out, err = capfd.readouterr()
        return int(stop.value.code or 0), out, err

    return call


@pytest.fixture
def refused(run: Run) -> Refused:
    def call(*arguments: object) -> str:
        code, out, err = run(*arguments)
        assert code == 2, (out, err)
        assert len(err.strip().splitlines()) == 1, err
        assert err.startswith("error: ")
        return err

    return call


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "out"


def left_behind(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.rglob("*")) if folder.exists() else []


def test_help_names_every_command(run: Run) -> None:
    code, out, _ = run("--help")
    assert code == 0
    for command in ("make", "read", "scan", "templates", "params", "reproduce", "bench"):
        assert command in out


def test_module_and_command_are_the_same_program() -> None:
    result = subprocess.run(
        [sys.executable, "-m", "perfqr_cad", "--version"], capture_output=True, text=True, check=True
    )
    assert result.stdout.startswith("perfqr ")


def test_importing_the_command_loads_no_kernel() -> None:
    heavy = "('OCP', 'cv2', 'gmsh', 'scipy', 'numpy')"
    code = f"import sys, perfqr_cad.cli; print([m for m in {heavy} if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_templates_and_params_as_json(run: Run) -> None:
    code, out, _ = run("templates", "--json")
    assert code == 0
    assert "plate" in [t["name"] for t in json.loads(out)]
    code, out, _ = run("params", "plate", "--json")
    assert code == 0
    assert "size" in [p["name"] for p in json.loads(out)["parameters"]]


def test_not_an_image(tmp_path: Path, folder: Path, refused: Refused) -> None:
    path = tmp_path / "notes.png"
    path.write_text("no picture")
    assert "notes.png" in refused("make", "--image", path, "-o", f"{folder}/")
    assert left_behind(folder) == []
    assert "notes.png" in refused("read", path)


def test_missing_image(tmp_path: Path, refused: Refused) -> None:
    assert "none.png" in refused("read", tmp_path / "none.png")


def test_image_without_a_code(tmp_path: Path, folder: Path, refused: Refused) -> None:
    path = tmp_path / "grey.png"
    Image.new("L", (300, 300), 128).save(path)
    assert "no QR code" in refused("make", "--image", path, "-o", f"{folder}/")
    assert left_behind(folder) == []


def test_several_codes_in_one_image(tmp_path: Path, run: Run, refused: Refused) -> None:
    sheet, path = Image.new("L", (500, 250), 255), tmp_path / "two.png"
    for number, text in enumerate(("first", "other")):
        segno.make(text, micro=False).save(str(path), scale=8)
        with Image.open(path) as code:
            sheet.paste(code, (250 * number, 0))
    sheet.save(path)
    for command in (("read", path), ("make", "--image", path, "--json")):
        assert "two.png holds 2 QR codes: 1 'first', 2 'other'; choose one with --which N" in refused(
            *command
        )
    assert "there is no number 3" in refused("make", "--image", path, "--which", 3, "--json")
    assert "payload: other" in run("read", path, "--which", 2)[1]
    assert "which=1 has no effect without image: use an image or no --which" in refused(
        "make", "a text", "--which", 1, "--json"
    )


def test_code_damaged_beyond_its_capacity(tmp_path: Path, refused: Refused) -> None:
    path = tmp_path / "damaged.png"
    segno.make(TEXT, error="l", version=5, micro=False, boost_error=False).save(str(path), scale=8)
    with Image.open(path) as picture:
        damaged = picture.convert("L")
    damaged.paste(255, (140, 110, 300, 290))
    damaged.save(path)
    message = refused("read", path)
    assert "block" in message
    assert "13" in message  # version 5-L: one block of 26 check codewords bears 13 wrong ones


def test_payload_too_long_for_the_version(folder: Path, refused: Refused) -> None:
    message = refused("make", "x" * 500, "--version", 5, "-o", f"{folder}/")
    assert "version 5-M holds 86" in message  # data codewords of 5-M: ISO/IEC 18004 Table 7
    assert "use --version" in message
    assert left_behind(folder) == []


def test_module_thinner_than_the_nozzle(folder: Path, refused: Refused) -> None:
    message = refused("make", TEXT, "--size", 10, "-o", f"{folder}/")
    assert "--size" in message
    assert left_behind(folder) == []


@pytest.mark.parametrize(
    "option",
    [
        ("--size", -5),
        ("--size", "wide"),
        ("--size", "nan"),
        ("--size", 1e9),
        ("--thickness", 0),
        ("--thickness", -1),
        ("--thickness", "inf"),
        ("--nozzle", 0),
        ("--version", 41),
        ("--pressure", -1),
        ("--yield", -10),
        ("--draft", 90),
        ("--style", "stars"),
        ("--material", "cheese"),
        ("-D", "size"),
        ("-D", "siez=30"),
    ],
)
def test_absurd_values(option: tuple[str, object], folder: Path, refused: Refused) -> None:
    refused("make", TEXT, *option, "-o", f"{folder}/")
    assert left_behind(folder) == []


def test_neither_and_both_of_text_and_picture(tmp_path: Path, folder: Path, refused: Refused) -> None:
    assert "text" in refused("make", "", "-o", f"{folder}/")
    assert "nothing to write" in refused("make", TEXT)


def test_unknown_format_and_unwritable_folder(tmp_path: Path, refused: Refused) -> None:
    assert ".step" in refused("make", TEXT, "-o", tmp_path / "part.xyz")
    file = tmp_path / "file"
    file.write_text("")
    refused("make", TEXT, "-o", file / "part.step")
    refused("make", TEXT, "-o", "/proc/nowhere/part.step")


LONG = "n" * 300


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("-P", "small"), "-P names a parameter set only together with -p FILE"),
        (("-p", "sets.json"), "-p names a parameter set only together with -P NAME"),
        (("--hole", "4", "--hole", "5", "--frame", "8"), "two diameters"),
        (("--size", "40", "--size", "50"), "size is given twice"),
        (("--size", "40", "-D", "size=50"), "size is given twice"),
        (("-D", "size=40", "-D", "size=50"), "size is given twice"),
        (("--text", "another"), "text is given twice"),
        (("--image", "code.png"), "text and image are given together"),
        (("-t", "bottle", "--frame", "3"), "template 'bottle' does not take 'frame'"),
        (("-D", "siez=30"), "did you mean 'size'"),
        (("-D", "version=2.5"), "version='2.5' is no whole number: give 1 to 40"),
        (("-D", "quiet=2.5"), "no whole number"),
        (("-D", "seed=0.5"), "no whole number"),
        (("-D", "size=1" + "0" * 400), "is not a finite number"),
        (("-D", "size={[]:1}"), "is no number"),
        (("-D", "size=" + "-" * 5000 + "1"), "is no number"),
        (("--caption", "x" * 20_000), "limit 500"),
        (("--caption", "\u200b"), "of blanks alone"),
        (("--caption", "a\u200bb", "--frame", "8"), "U+200B, zero width space: leave it out"),
        (("--caption", "lab 日", "--frame", "8"), "has no shape for '日' (U+65E5)"),
        (("--caption", "lab", "--frame", "8", "--font", "No Such Font"), "is not installed"),
        (("--caption", "lab", "--frame", "8", "--font", "/dev/zero"), "is not installed"),
        (("--caption", "lab", "--frame", "8", "--caption-place", "left"), "bottom"),
        (("--caption", "lab"), "needs a frame"),
        (("-D", f"{LONG}=1"), "does not take"),
        (("-t", f"{LONG}.py"), "name a template (.py)"),
        (("-t", LONG), "no template"),
        (("-t", "/dev/zero"), "no template"),
        (("-p", LONG, "-P", "x"), "name a file of parameter sets"),
        (("--template-timeout", "0"), "seconds above 0"),
        (("--template-timeout", "nan"), "seconds above 0"),
    ],
)
def test_options_that_cannot_be_meant(
    arguments: tuple[str, ...], says: str, folder: Path, refused: Refused
) -> None:
    assert says in refused("make", TEXT, *arguments, "-o", f"{folder}/")
    assert left_behind(folder) == []


@pytest.mark.parametrize("text", ["", " ", "\t\n", "\u200b\u00a0", "x" * 20_000, "\udcff"])
def test_texts_that_are_none(text: str, folder: Path, refused: Refused) -> None:
    assert "text" in refused("make", text, "-o", f"{folder}/")
    assert left_behind(folder) == []


@pytest.mark.parametrize(
    ("outputs", "says"),
    [
        (("d/a.svg", "d/a.svg/"), "cannot be a file and a folder"),
        (("a.svg", "a.svg/b.svg"), "cannot be a file and a folder"),
        ((f"{LONG}.step",), "name too long"),
        ((f"{LONG}/",), "name too long"),
        ((f"{LONG}/a.svg",), "name too long"),
    ],
)
def test_outputs_are_refused_before_the_work(
    outputs: tuple[str, ...], says: str, tmp_path: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("perfqr_cad.catalog.Template.build", None)
    words = [word for output in outputs for word in ("-o", f"{tmp_path}/{output}")]
    assert says in refused("make", TEXT, *words)
    assert left_behind(tmp_path) == []


def test_a_caption_of_two_lines_is_on_the_part_and_in_its_drawing(tmp_path: Path, run: Run) -> None:
    words = ("--size", 40, "--frame", 10, "--caption", "Łódź © 5\nشقة $6", "--caption-place", "top")
    code, out, err = run("make", "HELLO", *words, "-o", tmp_path / "part.svg", "--json")
    assert code == 0, err
    assert json.loads(out)["solid"]["valid"]
    drawing = (tmp_path / "part.svg").read_text()
    assert 'id="engrave"' in drawing


def test_a_folder_that_is_missing_is_made(tmp_path: Path, run: Run) -> None:
    code, _, err = run("make", "HELLO", "--size", 40, "-o", tmp_path / "new" / "deeper" / "part.svg")
    assert (code, err) == (0, "")
    assert left_behind(tmp_path) == ["deeper", "new", "part.svg"]


@pytest.mark.parametrize("text", ["1.50", "12E3", "1_000", "0x1F", "+42", "00.5", "true", " hi "])
@pytest.mark.parametrize("door", ["argument", "--text", "-D", "-p"])
def test_the_payload_is_the_text_letter_by_letter(text: str, door: str, tmp_path: Path) -> None:
    sets = tmp_path / "sets.json"
    sets.write_text(json.dumps({"parameterSets": {"s": {"text": text}}}))
    words = {
        "argument": [text],
        "--text": ["--text", text],
        "-D": ["-D", f"text={text}"],
        "-p": ["-p", str(sets), "-P", "s"],
    }[door]
    assert asked(*words)["text"] == text


def test_every_door_reads_a_setting_alike(tmp_path: Path) -> None:
    sets = tmp_path / "sets.json"
    sets.write_text(
        json.dumps({"parameterSets": {"s": {"size": "4e1", "verify_solid": "true", "hole": "3"}}})
    )
    by_option = asked("A", "--size", "4e1", "--verify-solid", "--hole", "3")
    assert by_option["size"] == 40
    assert by_option == asked("A", "-D", "size=4e1", "-D", "verify_solid=true", "-D", "hole=3")
    assert by_option == asked("A", "-p", str(sets), "-P", "s")


def test_what_is_given_by_name_beats_the_set(tmp_path: Path) -> None:
    sets = tmp_path / "sets.json"
    sets.write_text(json.dumps({"parameterSets": {"s": {"image": "code.png", "size": "30", "quiet": "2"}}}))
    values = asked("A", "--size", "40", "-p", str(sets), "-P", "s")
    assert (values["text"], values["image"], values["size"], values["quiet"]) == ("A", None, 40, 2)


def asked(*arguments: str) -> dict[str, object]:
    """The values that the plate would be built with."""
    seen: list[dict[str, object]] = []

    def keep(_: object, values: dict[str, object], **__: object) -> None:
        seen.append(values)
        raise DesignError("seen")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("perfqr_cad.catalog.Template.build", keep)
        with pytest.raises(SystemExit):
            main(["make", *arguments, "--json"])
    return seen[0]


def test_help_of_make_lists_every_setting_with_its_range(run: Run) -> None:
    _, out, _ = run("make", "--help")
    told = " ".join(out.split())
    for declared in SETTINGS:
        assert f" {declared.option} " in told
        if declared.minimum is not None:
            assert declared.wanted in told
    for group in GROUPS:
        assert f"{group}:" in out


def test_the_schema_of_parameters(run: Run) -> None:
    code, out, _ = run("params", "plate", "--schema")
    assert code == 0
    size = json.loads(out)["properties"]["size"]
    assert (size["type"], size["minimum"], size["maximum"], size["unit"]) == (
        ["number", "null"],
        1,
        10_000,
        "mm",
    )
