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
    assert "use version" in message
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
