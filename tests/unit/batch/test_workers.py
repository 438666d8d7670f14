"""Batches from the command line: rows made, kept, refused and crashed."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from perfqr_cad import catalog
from perfqr_cad.batch import Plan, read_table, run
from perfqr_cad.batch.journal import Journal

# A template that makes parts, and dies of native code where it is asked to.
TEMPLATE = '''"""A plate, or a crash."""
import os, signal
from perfqr_cad import make, settings
# [Shared: Code, Look]
def build(p):
    if p.text == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    return make(**settings(p))
'''
TABLE = "name,text,size\na,HELLO,40\nb,crash,40\nc,tiny,2\nCON,x,40\nd,WORLD,40\n"


def call(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "perfqr_cad", "batch", "labels.csv", "-t", "t.py", "-o", "out"]
    return subprocess.run([*command, *options], cwd=folder, capture_output=True, text=True, check=False)


def digests(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.glob("*.stl")}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    folder = tmp_path_factory.mktemp("batch")
    (folder / "t.py").write_text(TEMPLATE)
    (folder / "labels.csv").write_text(TABLE)
    return folder, call(folder, "--jobs", "2")


def test_one_bad_row_stops_no_other(made: tuple[Path, subprocess.CompletedProcess[str]]) -> None:
    folder, ended = made
    assert ended.returncode == 4, ended.stderr
    with (folder / "out" / "batch.csv").open(encoding="utf-8-sig", newline="") as table:
        rows = list(csv.DictReader(table))
    assert [row["status"] for row in rows] == ["made", "failed", "refused", "refused", "made"]
    assert "native code ended the process" in rows[1]["note"]
    assert "size 2 mm" in rows[2]["note"]
    assert "a device on Windows" in rows[3]["note"]
    assert "Traceback" not in ended.stderr
    assert sorted(digests(folder / "out")) == ["a.stl", "d.stl"]
    assert not list((folder / "out").glob(".perfqr-*"))


def test_a_row_is_the_same_as_by_itself(made: tuple[Path, subprocess.CompletedProcess[str]]) -> None:
    folder, _ = made
    command = [sys.executable, "-m", "perfqr_cad", "make", "HELLO", "--size", "40", "-o", "single.stl"]
    subprocess.run(command, cwd=folder, capture_output=True, check=True)
    assert (folder / "single.stl").read_bytes() == (folder / "out" / "a.stl").read_bytes()


def test_what_is_there_is_kept_and_what_is_not_is_made_again(
    made: tuple[Path, subprocess.CompletedProcess[str]],
) -> None:
    folder, _ = made
    before = digests(folder / "out")
    (folder / "out" / "d.stl").write_bytes(b"cut short")
    with (folder / "out" / "batch.jsonl").open("a") as journal:
        journal.write('{"name": "e", "ke')  # as a kill leaves it
    (folder / "labels.csv").write_text("name,text,size\na,HELLO,40\nd,WORLD,40\n")
    ended = call(folder)
    assert ended.returncode == 0, ended.stderr
    assert "1 kept, 1 made" in ended.stdout
    assert digests(folder / "out") == before
    assert set(dict(Journal(folder / "out" / "batch.jsonl")._entries)) == {"a", "d"}


def test_a_killed_batch_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    (tmp_path / "t.py").write_text(TEMPLATE)
    (tmp_path / "labels.csv").write_text("name,text,size\na,HELLO,40\nb,WORLD,40\n")
    command = [sys.executable, "-m", "perfqr_cad", "batch", "labels.csv", "-t", "t.py", "-o", "out"]
    with subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as running:
        assert running.stderr is not None
        assert "row 1 a: made" in running.stderr.readline()
        os.killpg(running.pid, signal.SIGKILL)
        running.stderr.read()
    ended = call(tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert "1 kept, 1 made" in ended.stdout
    assert sorted(digests(tmp_path / "out")) == ["a.stl", "b.stl"]


def test_workers_of_a_cluster_make_the_same(
    made: tuple[Path, subprocess.CompletedProcess[str]], tmp_path: Path
) -> None:
    distributed = pytest.importorskip("distributed")
    (tmp_path / "labels.csv").write_text("name,text,size\na,HELLO,40\nd,WORLD,40\n")
    plan = Plan(catalog.load(made[0] / "t.py"), {}, tmp_path / "out", None, (".stl", ".json"), 60.0)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        summary = run(plan, read_table(tmp_path / "labels.csv"), scheduler=cluster.scheduler_address)
    assert summary.complete
    assert digests(tmp_path / "out") == digests(made[0] / "out")
    certificate = json.loads((tmp_path / "out" / "a.json").read_text())
    assert certificate["payload"] == "HELLO"


def test_an_absent_scheduler_is_one_line(made: tuple[Path, subprocess.CompletedProcess[str]]) -> None:
    folder, _ = made
    (folder / "labels.csv").write_text("name,text,size\nz,HELLO,41\n")
    ended = call(folder, "--scheduler", "tcp://127.0.0.1:9")
    assert ended.returncode == 2
    assert "no Dask scheduler answers" in ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1
