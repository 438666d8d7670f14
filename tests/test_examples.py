"""Every example and every block of Python and shell in the README runs."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
BLOCKS = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), flags=re.DOTALL)
SHELL = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text(), flags=re.DOTALL)
EXAMPLE_ARGUMENTS = {"label.py": ["labels", "1"], "picture_code.py": ["picture.png"]}


def run(command: list[str], folder: Path) -> None:
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_example_runs_and_is_short(example: Path, tmp_path: Path) -> None:
    assert len(example.read_text().splitlines()) < 30
    run([sys.executable, str(example), *EXAMPLE_ARGUMENTS.get(example.name, [])], tmp_path)
    assert any(tmp_path.rglob("*.*"))


@pytest.mark.parametrize("block", BLOCKS)
def test_readme_python_runs(block: str, tmp_path: Path) -> None:
    run([sys.executable, "-c", block], tmp_path)


@pytest.mark.parametrize("block", SHELL)
def test_readme_commands_run(block: str, tmp_path: Path) -> None:
    assert block
    for line in block.splitlines():
        program, *words = shlex.split(line)
        assert program == "perfqr"
        run([sys.executable, "-m", "perfqr_cad", *words], tmp_path)
