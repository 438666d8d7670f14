"""Foreign code in processes of its own: what it answers, how it fails, and that nothing of it reaches us."""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from perfqr_cad import isolated
from perfqr_cad.errors import DesignError, KernelError
from perfqr_cad.isolated import (
    Crashed,
    Failed,
    Limits,
    Message,
    OutOfMemory,
    OutOfTime,
    Refusal,
    Worker,
    once,
    wire,
)
from perfqr_cad.isolated.process import LOOK_S
from perfqr_cad.isolated.worker import READING_GB, READING_S, reading_limits

HEAD = """
import ctypes, os, random, signal, sys
import numpy as np
from perfqr_cad.errors import DesignError
from perfqr_cad.isolated import Message, without_files

def job(*arguments):
    def answer(request):
        {body}
    return answer
"""
PACKAGE = Path(isolated.__file__).resolve().parents[2]
SMALL = Limits(cpu_s=0.3, memory_bytes=400 * 2**20)

Job = Callable[[str], str]


@pytest.fixture
def job(tmp_path: Path) -> Job:
    """Makes a job of the body of its answering function."""

    def make(body: str) -> str:
        path = tmp_path / "job.py"
        path.write_text(HEAD.format(body=body))
        return f"{path}:job"

    return make


def ask(job: str, *arguments: object, limits: Limits = SMALL) -> Message:
    worker = Worker(job, *arguments, limits=limits)
    try:
        return worker.ask({"n": 2}, np.arange(6.0).reshape(2, 3), np.zeros((0, 4), np.uint8))
    finally:
        worker.stop()


def test_values_and_arrays_go_there_and_back(job: Job) -> None:
    body = "return Message([request.value, arguments], tuple(a.astype('<f4') for a in request.arrays))"
    answer = ask(job(body), "text", 3)
    assert answer.value == [{"n": 2}, ["text", 3]]
    first, empty = answer.arrays
    assert np.array_equal(first, np.arange(6, dtype=np.float32).reshape(2, 3))
    assert first.dtype == np.float32
    assert empty.shape == (0, 4)


def test_errors_of_ours_come_back_as_themselves(job: Job) -> None:
    with pytest.raises(DesignError, match=r"^too wide: 3 of 2$"):
        ask(job("raise DesignError('too wide: 3 of 2')"))


@pytest.mark.parametrize(
    ("body", "kind", "says"),
    [
        ("raise ValueError('two\\nlines')", Failed, "^ValueError: two lines$"),
        ("def f(): return f()\n        f()", Failed, "RecursionError"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", Crashed, "^crashed by SIGSEGV$"),
        ("os.write(2, b'first\\nlast words\\n\\n'); os.abort()", Crashed, "SIGABRT: last words$"),
        ("ctypes.string_at(0)", Crashed, "SIGSEGV"),
        ("os._exit(3)", Crashed, "exit code 3"),
        ("sys.exit('bye')", Crashed, "exit code 1: bye"),
        ("return Message(None, (bytearray(2**30),))", OutOfMemory, r"needs more than 0\.4 GB of memory"),
        ("os.write(2, b'memory allocation of 9 bytes failed'); os.abort()", OutOfMemory, "0.4 GB"),
        ("while True: pass", OutOfTime, r"^no end after 0\.3 s of computing$"),
    ],
)
def test_every_bad_end_is_one_line(job: Job, body: str, kind: type[Exception], says: str) -> None:
    with pytest.raises(kind, match=says) as caught:
        ask(job(body))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("megabytes", "kind"), [(50, "Crashed"), (350, "OutOfMemory")])
def test_native_code_that_dies_near_its_limit_had_too_little_memory(
    job: Job, megabytes: int, kind: str
) -> None:
    script = (
        f"import sys; sys.path[:0] = [{str(PACKAGE)!r}]\n"
        "from perfqr_cad.isolated import IsolationError, Limits, Worker\n"
        f"worker = Worker({job(f'x = np.ones({megabytes} * 2**17); os.abort()')!r},\n"
        "    limits=Limits(memory_bytes=400 * 2**20))\n"
        "try:\n    worker.ask()\n"
        "except IsolationError as reason:\n    print(type(reason).__name__)\n"
    )
    # A parent that is small itself: a child begins as its copy, whose memory counts.
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == kind


def test_a_process_that_dies_at_its_start_says_why_at_once(tmp_path: Path) -> None:
    (tmp_path / "job.py").write_text("raise ImportError('libnowhere.so.0: no such file')")
    with pytest.raises(Crashed, match=r"exit code 1: ImportError: libnowhere\.so\.0: no such file"):
        ask(f"{tmp_path / 'job.py'}:job")
    with pytest.raises(Crashed, match=r"No module named 'perfqr_cad\.nothere'"):
        ask("perfqr_cad.nothere:job")


def test_a_dead_process_is_replaced(job: Job) -> None:
    worker = Worker(job("return Message(1 // len(request.arrays)) if request.value else os._exit(1)"))
    try:
        with pytest.raises(Crashed):
            worker.ask(None)
        with pytest.raises(Failed, match="ZeroDivisionError"):
            worker.ask("x")
        assert worker.ask("x", np.zeros(1)).value == 1
    finally:
        worker.stop()


def test_waiting_for_nothing_is_an_end_too(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("perfqr_cad.isolated.process.STALL_S", 0.1)
    with pytest.raises(OutOfTime, match="nothing happened"):
        ask(job("signal.pause()"))


def test_another_thread_can_stop_it(job: Job) -> None:
    worker = Worker(job("signal.pause()"), limits=SMALL)
    assert worker.report is None
    ends: list[BaseException] = []

    def wait() -> None:
        try:
            worker.ask()
        except Crashed as end:
            ends.append(end)

    thread = threading.Thread(target=wait)
    thread.start()
    time.sleep(LOOK_S / 10)
    worker.stop()
    thread.join()
    assert len(ends) == 1


def test_no_code_of_the_current_folder_or_of_the_environment_runs(tmp_path: Path, job: Job) -> None:
    for name in ("random", "numpy", "json", "perfqr_cad", "sitecustomize", "usercustomize", "startup"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'RUN')!r}, 'w').write({name!r})")
    body = "return Message([random.__file__, os.getcwd(), [p for p in sys.path if 'pytest' in p]])"
    ask_there = (
        f"import sys; sys.path[:0] = [{str(PACKAGE)!r}]\n"
        "from perfqr_cad.isolated import Worker\n"
        f"sys.path[:0] = ['', {str(tmp_path)!r}]\n"
        f"worker = Worker({job(body)!r})\n"
        "print(worker.ask().value)\n"
        "worker.stop()\n"
    )
    script = tmp_path.parent / f"{tmp_path.name}.py"
    script.write_text(ask_there)
    folder = str(tmp_path)
    done = subprocess.run(
        [sys.executable, "-I", str(script)],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": folder, "PYTHONSTARTUP": f"{folder}/startup.py", "PYTHONHOME": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert folder not in done.stdout.replace("[]", "")
    assert "'/', []]" in done.stdout
    assert not (tmp_path / "RUN").exists()


def test_no_file_can_be_opened_where_that_is_forbidden(job: Job) -> None:
    body = "\n        ".join(("with without_files():", "    os.open('/dev/null', 0)", "return Message(None)"))
    with pytest.raises(Failed, match=r"OSError.*Too many open files"):
        ask(job(body))
    assert (
        ask(job("with without_files(): pass\n        return Message(open('/dev/null').read())")).value == ""
    )


# Native code that holds the interpreter, computing or waiting.
@pytest.mark.parametrize("busy", ["ctypes.PyDLL(None).sleep(600)", "sum(range(10**11))"])
def test_it_ends_with_us_however_we_end(tmp_path: Path, job: Job, busy: str) -> None:
    pid = tmp_path / "pid"
    body = f"open({str(pid)!r}, 'w').write(str(os.getpid())); {busy}"
    script = (
        f"import sys; sys.path[:0] = [{str(PACKAGE)!r}]\n"
        "from perfqr_cad.isolated import Worker\n"
        f"Worker({job(body)!r}).ask()\n"
    )
    with subprocess.Popen([sys.executable, "-c", script]) as parent:
        while not (pid.exists() and pid.read_text()):
            time.sleep(0.02)
        parent.kill()
    child = int(pid.read_text())
    for _ in range(500):
        if not _runs(child):
            return
        time.sleep(0.02)
    os.kill(child, signal.SIGKILL)
    pytest.fail("the child outlived its parent")


def _runs(process: int) -> bool:
    stat = Path(f"/proc/{process}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] not in "ZX"


def test_a_fork_starts_a_process_of_its_own(job: Job) -> None:
    worker = Worker(job("return Message(os.getppid())"))
    try:
        assert worker.ask().value == os.getpid()
        fork = os.fork()
        if fork == 0:
            right = False
            try:
                right = worker.ask().value == os.getpid()
                worker.stop()
            finally:
                os._exit(0 if right else 1)
        assert os.waitpid(fork, 0)[1] == 0
        assert worker.ask().value == os.getpid()
    finally:
        worker.stop()


def test_refusals_name_the_file_the_reason_and_the_remedy(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(READING_S, "0.2")
    refusal = Refusal(KernelError, "a.stl cannot be read", "export it again")
    with pytest.raises(KernelError, match=r"^a\.stl cannot be read \(crashed by SIGABRT\): export it again$"):
        once(job("os.abort()"), (), Message(), refusal)
    with pytest.raises(
        KernelError, match=rf"no end after 0\.2 s of computing\): simplify it, .* {READING_S}$"
    ):
        once(job("while True: pass"), (), Message(), refusal)
    monkeypatch.setenv(READING_S, "30")  # the remedy
    assert once(job("sum(range(10**7)); return Message(7)"), (), Message(), refusal).value == 7
    body = job("return Message(len(bytearray(5 * 10**8)))")
    monkeypatch.setenv(READING_GB, "0.4")
    with pytest.raises(KernelError, match=rf"more than 0\.4 GB of memory\): simplify it, .* {READING_GB}$"):
        once(body, (), Message(), refusal)
    monkeypatch.setenv(READING_GB, "0.8")
    assert once(body, (), Message(), refusal).value == 5 * 10**8


@pytest.mark.parametrize("allowed", ["much", "nan", "-1", "0", "1e9"])
def test_a_bound_that_is_none_is_refused(monkeypatch: pytest.MonkeyPatch, allowed: str) -> None:
    monkeypatch.setenv(READING_S, allowed)
    with pytest.raises(DesignError, match=f"{READING_S}='{allowed}'"):
        reading_limits()


def sent(header: bytes, rest: bytes = b"") -> Callable[[memoryview], None]:
    """A source of a message of raw bytes."""
    data = struct.pack("!I", len(header)) + header + rest

    def fill(buffer: memoryview) -> None:
        nonlocal data
        buffer[:], data = data[: len(buffer)], data[len(buffer) :]

    return fill


@pytest.mark.parametrize(
    ("header", "says"),
    [
        (b'{"value": 1, "arrays": [["|O", [1]]]}', "no numbers"),
        (b'{"value": 1, "arrays": [["<U8", [1]]]}', "no numbers"),
        (b'{"value": 1, "arrays": [["<f8", [-1]]]}', "no numbers"),
        (b'{"value": 1, "arrays": [["<f8", [1000, 1000]]]}', "more than 1000 bytes"),
        (b'{"value": 1, "arrays": 3}', "none"),
        (b"[" * 100_000, "none"),
        (b"\x80\x04\x95", "codec|none"),
        (b"{}", "none"),
    ],
)
def test_what_is_no_message_is_refused(header: bytes, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        wire.receive(sent(header), 1000)


def test_an_answer_that_is_no_message_is_a_crash(job: Job) -> None:
    body = "os.write(int(json.loads(sys.argv[1])['channel']), b'\\x00\\x00\\x00\\x01x'); signal.pause()"
    with pytest.raises(Crashed, match="answered"):
        ask(job(f"import json; {body}"))


def test_a_message_is_what_was_sent() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        wire.send(Message("ä", (np.eye(2), np.array([True]))), ours.sendall)
        found = wire.receive(lambda buffer: theirs.recv_into(buffer), 100)
    assert found.value == "ä"
    assert np.array_equal(found.arrays[0], np.eye(2))
