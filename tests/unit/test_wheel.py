"""The wheel as a stranger installs it: into an environment of its own, run outside of the checkout."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ("perfqr_cad", "templates", "pyproject.toml", "setup.py", "README.md", "LICENSE")


def call(*words: object, folder: Path) -> str:
    """Run a program in a folder, without the paths of this process; what it prints."""
    surroundings = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    ended = subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        env=surroundings,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The command `perfqr` of an environment that has the wheel, and the dependencies of this one."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    for name in SOURCES:  # a copy: building leaves files behind
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        source.mkdir(exist_ok=True)
        copy(ROOT / name, source / name)
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    call(*pip, "wheel", "--no-deps", "--no-build-isolation", "-w", folder, source, folder=folder)
    venv.create(folder / "environment", with_pip=False, symlinks=True)
    python = folder / "environment" / "bin" / "python"
    wheel = next(folder.glob("*.whl"))
    call(*pip, "--python", python, "install", "--no-deps", "--no-index", wheel, folder=folder)
    packages = next((folder / "environment").glob("lib/python*/site-packages"))
    # A plain path: the editable install of the checkout, itself a .pth file, is not read from there.
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python.with_name("perfqr")


def test_the_installed_package_is_the_wheels(installed: Path) -> None:
    where = call(
        installed.with_name("python"), "-c", "import perfqr_cad; print(perfqr_cad.__file__)", folder=Path("/")
    )
    assert installed.parents[1] in Path(where.strip()).parents


def test_it_lists_the_templates(installed: Path, tmp_path: Path) -> None:
    listed = [line.split()[0] for line in call(installed, "templates", folder=tmp_path).splitlines()]
    assert listed == sorted(path.stem.replace("_", "-") for path in (ROOT / "templates").glob("*.py"))


@pytest.mark.parametrize("words", [("--size", "40"), ("-t", "bottle", "--size", "32", "-D", "diameter=70")])
def test_it_makes_a_part_outside_of_the_checkout(
    installed: Path, words: tuple[str, ...], tmp_path: Path
) -> None:
    small = ("--level", "L", "--quiet", "2", "--nozzle", "0.3")
    call(installed, "make", "A", *small, *words, "-o", "x.svg", folder=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["x.svg"]
