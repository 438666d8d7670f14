"""A short run of every fuzz target."""

import subprocess
import sys
from pathlib import Path

import pytest

TARGETS = Path(__file__).with_name("doors.py")
RUNS = 2000


@pytest.mark.parametrize("door", ["svg", "mesh", "3mf", "step", "json", "template"])
def test_nothing_is_found_soon(tmp_path: Path, door: str) -> None:
    command = [sys.executable, str(TARGETS), door, f"-runs={RUNS}", "-seed=1", "-max_len=4000"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
