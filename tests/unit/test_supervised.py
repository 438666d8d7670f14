"""A run ends at once with a signal, tells of a crash, and leaves nothing behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from perfqr_cad import scratch
from perfqr_cad.errors import DesignError
from perfqr_cad.export.staging import staged
from perfqr_cad.scratch import _alive

HEAD = """
import ctypes, os, signal, sys
from pathlib import Path
from perfqr_cad import scratch, supervised
from perfqr_cad.export.staging import staged

folder = Path(sys.argv[1])

def stuck():
    with staged(folder / "made") as stage:
        (stage / "half.step").write_text("half")
        print("ready", os.getpid(), flush=True)
        ctypes.PyDLL(None).sleep(600)  # native code that never lets Python act
    return 0
"""


def program(folder: Path, body: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", HEAD + body, str(folder)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGINT, 130)]
)
def test_a_signal_ends_native_code_and_leaves_nothing(
    tmp_path: Path, number: signal.Signals, code: int
) -> None:
    with program(tmp_path, "sys.exit(supervised.run(stuck))") as running:
        assert running.stdout is not None
        assert running.stdout.readline().startswith("ready")
        running.send_signal(number)
        assert running.wait(timeout=60) == code
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_run_leaves_is_cleared_by_the_next(tmp_path: Path) -> None:
    with program(tmp_path, "sys.exit(stuck())") as running:  # nobody watches over it
        assert running.stdout is not None
        assert running.stdout.readline().startswith("ready")
        running.kill()
        running.wait(timeout=60)
    assert any(tmp_path.rglob(f"{scratch.PREFIX}*"))
    scratch.sweep()
    assert list(tmp_path.iterdir()) == []


def test_a_run_dies_with_its_supervisor(tmp_path: Path) -> None:
    with program(tmp_path, "sys.exit(supervised.run(stuck))") as running:
        assert running.stdout is not None
        child = int(running.stdout.readline().removeprefix("ready "))
        running.kill()
        running.wait(timeout=60)
        assert running.stdout.read() == ""  # ends only when the child has let go of it
    while _alive(child):  # a process closes its files a moment before it is no more
        time.sleep(0.01)
    scratch.sweep()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("body", "code", "told"),
    [
        ("sys.exit(supervised.run(lambda: 3))", 3, ""),
        ("supervised.run(lambda: 1 / 0)", 0, "ZeroDivisionError"),
        ("sys.exit(supervised.run(lambda: os.kill(os.getpid(), signal.SIGSEGV)))", 70, "(SIGSEGV); nothing"),
    ],
)
def test_the_exit_code_is_that_of_the_work(tmp_path: Path, body: str, code: int, told: str) -> None:
    with program(tmp_path, body) as running:
        _, errors = running.communicate(timeout=60)
    assert running.returncode == code
    assert told in errors


def _write_three(folder: Path) -> None:
    with staged(folder) as stage:
        for name in ("a", "aa", "b"):
            (stage / name).write_text("new")


def test_a_set_of_files_is_replaced_as_a_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "b").write_text("old")
    moves: list[object] = []
    replace = os.replace

    def fails_at_the_third(source: object, target: object) -> None:
        moves.append(target)
        if len(moves) == 3:
            raise OSError(28, "No space left on device")
        replace(source, target)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "replace", fails_at_the_third)
    with pytest.raises(DesignError, match="no space left"):
        _write_three(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b"]
    assert {path.read_text() for path in tmp_path.iterdir()} == {"old"}
