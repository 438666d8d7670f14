"""The whole chain: a text to all files, and a picture read."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from perfqr_cad.table import Table

TEXT = "https://example.com/p/1234567"
HELP_S, MAKE_S, READ_S = 0.4, 10.0, 1.0  # targets


def run() -> Table:
    """Whole-process seconds beside their targets, and the share of each step."""
    with tempfile.TemporaryDirectory() as folder:
        everything = ["make", TEXT, "--version", "5", "--size", "60", "-o", f"{folder}/part/"]
        picture = str(_picture(Path(folder)))
        rows = (
            ("perfqr --help", _best(["--help"]), HELP_S),
            ("version 5, text to all files", _best(everything, repeats=1), MAKE_S),
            ("read a picture", _best(["read", picture]), READ_S),
        )
        steps = _steps()
    return Table(
        "Spine: whole processes, imports included",
        ("command", "seconds", "target", "ratio to target"),
        tuple((name, taken, target, taken / target) for name, taken, target in rows),
        tuple(f"{step}: {seconds:.2f} s" for step, seconds in steps.items()),
    )


def _best(arguments: list[str], repeats: int = 3) -> float:
    taken: list[float] = []
    for _ in range(repeats):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-m", "perfqr_cad", *arguments], check=True, capture_output=True)
        taken.append(time.perf_counter() - begin)
    return min(taken)


def _picture(folder: Path) -> Path:
    import segno

    path = folder / "code.png"
    segno.make(TEXT, version=5, error="m", micro=False).save(str(path), scale=8)
    return path


def _steps() -> dict[str, float]:
    """Seconds by step of a design made in a process that is already warm."""
    from perfqr_cad.pipeline.chain import make

    make(TEXT, version=5, size_mm=60.0)
    return make(TEXT, version=5, size_mm=60.0).timings_s
