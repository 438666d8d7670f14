"""This side: a process that does one job, started when it is first asked and again after it has died."""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import IO, Any, NoReturn

from numpy.typing import NDArray

from perfqr_cad import errors
from perfqr_cad.isolated import wire
from perfqr_cad.isolated.wire import Message

CHILD = Path(__file__).resolve().with_name("child.py")
LOOK_S = 1.0  # how often a silent process is looked at
STALL_S = 60.0  # a process that has not worked at all for so long waits for what never comes
NO_SIGNAL = getattr(socket, "MSG_NOSIGNAL", 0)  # the solid modeller resets SIGPIPE, which would end us
# What a C++ or Rust library says when there is no memory, before it gives up.
NO_MEMORY = ("bad_alloc", "memory allocation of", "out of memory", "MemoryError", "Cannot allocate memory")
# Native libraries start as many threads as there are cores, for work that is over in milliseconds.
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


@dataclass(frozen=True)
class Limits:
    """Bounds of one answer: seconds of computing, and bytes of the process's own memory.

    Work is counted, not time: a busy machine changes no result.
    """

    cpu_s: float = 50.0
    memory_bytes: int = 1536 * 2**20


READING = Limits()  # with what this process itself takes: 60 s and 2 GB for a file that is refused


class IsolationError(Exception):
    """No answer came, and why: one line, to be translated by whoever asked."""


class OutOfTime(IsolationError):
    """It was still computing at the limit, or waited for what never came."""


class OutOfMemory(IsolationError):
    """It needed more memory than the limit."""


class Crashed(IsolationError):
    """The process ended before it answered."""


class Failed(IsolationError):
    """The job raised an exception that is none of ours."""


@dataclass
class _Process:
    """A running child and our ends of what connects us."""

    child: subprocess.Popen[bytes]
    channel: socket.socket
    lifeline: int
    stderr: IO[bytes]
    owner: int = field(default_factory=os.getpid)
    ready: bool = False

    def write(self, data: bytes | memoryview) -> None:
        """Send all of it. OSError when the process has ended, TimeoutError when it does not listen."""
        rest, patience = memoryview(data), _Patience(self.child.pid)
        while rest:
            try:
                rest = rest[self.channel.send(rest, NO_SIGNAL) :]
            except TimeoutError:
                patience.require_work()

    def fill(self, buffer: memoryview) -> None:
        """Fill a buffer with what comes. EOFError when the process has ended, TimeoutError when it waits."""
        patience = _Patience(self.child.pid)
        while buffer:
            try:
                count = self.channel.recv_into(buffer)
            except TimeoutError:
                patience.require_work()
                continue
            if count == 0:
                raise EOFError
            buffer = buffer[count:]

    def exit_code(self) -> int:
        """How it ended, once its end of the channel is closed; below 0: by which signal."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self.child.wait(timeout=LOOK_S)
        self.child.kill()
        return self.child.wait()

    def end(self) -> None:
        """Kill it with whatever it has started, and free what it held."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.child.pid, signal.SIGKILL)
        self.child.wait()
        self.close()

    def close(self) -> None:
        self.channel.close()
        os.close(self.lifeline)
        self.stderr.close()

    def last_words(self) -> str:
        """The last line that it wrote to its standard error."""
        if self.stderr.closed:
            return ""
        self.stderr.seek(0)
        lines = self.stderr.read().decode(errors="replace").split("\n")
        return next((" ".join(line.split())[:160] for line in reversed(lines) if line.strip()), "")


class _Patience:
    """How long a process may be silent: as long as it works, and `STALL_S` more."""

    def __init__(self, pid: int) -> None:
        self._pid, self._since, self._worked_s = pid, time.monotonic(), _cpu_s(pid)

    def require_work(self) -> None:
        """TimeoutError if the process has not worked for `STALL_S`."""
        now_s = _cpu_s(self._pid)
        if now_s != self._worked_s:
            self._since, self._worked_s = time.monotonic(), now_s
        elif time.monotonic() - self._since > STALL_S:
            raise TimeoutError


class Worker:
    """A job in a process of its own. `ask` may be called from several threads; answers come one by one."""

    def __init__(self, job: str, *arguments: Any, limits: Limits = READING) -> None:
        """`job` is `package.module:function` (or `/absolute/file.py:function`), called with `arguments`."""
        self._job, self._arguments, self._limits = job, arguments, limits
        self._lock = threading.RLock()
        self._process: _Process | None = None
        self._report: Any = None

    def start(self) -> None:
        """Start the process without waiting for it."""
        with self._lock:
            if self._process is not None and self._process.owner != os.getpid():
                self._process.close()  # it is our parent's: we are a fork
                self._process = None
            if self._process is None:
                self._process = _started(self._job, self._arguments, self._limits)

    @property
    def report(self) -> Any:
        """What the job said of its start. Starts it if need be; an `IsolationError` says why it does not."""
        with self._lock:
            self._running()
            return self._report

    def ask(self, value: Any = None, *arrays: NDArray[Any]) -> Message:
        """The job's answer. `PerfQRError` as the job raised it; else an `IsolationError` says why there is
        none."""
        with self._lock:
            answer = self._exchange(self._running(), Message(value, arrays))
        if "error" in answer.value:
            _raise(*answer.value["error"], self._limits)
        return Message(answer.value["answer"], answer.arrays)

    def stop(self) -> None:
        """End the process, whatever it is doing; who waits for an answer is told that it crashed."""
        process = self._process
        if process is None:
            return
        if process.owner == os.getpid():
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.child.pid, signal.SIGKILL)
        with self._lock:
            self._forget()

    def _running(self) -> _Process:
        self.start()
        process = self._process
        assert process is not None
        if not process.ready:
            self._report = self._exchange(process).value["ready"]
            process.ready = True
        return process

    def _exchange(self, process: _Process, request: Message | None = None) -> Message:
        """Send a request, if there is one, and wait for what comes."""
        try:
            if request is not None:
                wire.send(request, process.write)
            answer = wire.receive(process.fill, self._limits.memory_bytes)
            if not isinstance(answer.value, dict):
                raise ValueError("an answer that is none")
        except (OSError, EOFError, ValueError) as error:
            reason = self._reason(process, error)
            self._forget()
            raise reason from error
        except BaseException:  # half an answer is left in the channel
            self._forget()
            raise
        return answer

    def _forget(self) -> None:
        if self._process is not None and self._process.owner == os.getpid():
            self._process.end()
        self._process = None

    def _reason(self, process: _Process, error: Exception) -> IsolationError:
        """Why a process gave no answer."""
        if isinstance(error, TimeoutError):
            return OutOfTime(f"nothing happened for {STALL_S:g} s")
        if isinstance(error, ValueError):
            return Crashed(f"answered {error}")
        code = process.exit_code()
        words = process.last_words()
        if code == -signal.SIGPROF:
            return OutOfTime(f"no end after {self._limits.cpu_s:g} s of computing")
        if any(sign in words for sign in NO_MEMORY):
            return _out_of_memory(self._limits)
        how = f"crashed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        return Crashed(f"{how}: {words}" if words else how)


def once(
    job: str,
    arguments: tuple[Any, ...],
    request: Message,
    refusal: Callable[[IsolationError], errors.PerfQRError],
    limits: Limits = READING,
) -> Message:
    """The answer of a process that is started for it. Raises `PerfQRError`: the job's own, or `refusal`."""
    worker = Worker(job, *arguments, limits=limits)
    try:
        return worker.ask(request.value, *request.arrays)
    except IsolationError as reason:
        raise refusal(reason) from reason
    finally:
        worker.stop()


@cache
def kept(job: str, *arguments: Any, limits: Limits = READING) -> Worker:
    """A worker that is kept for the life of this process, for short jobs that come often."""
    worker = Worker(job, *arguments, limits=limits)
    atexit.register(worker.stop)
    return worker


def _started(job: str, arguments: tuple[Any, ...], limits: Limits) -> _Process:
    ours, theirs = socket.socketpair()
    ours.settimeout(LOOK_S)
    alive, lifeline = os.pipe()
    stderr = tempfile.TemporaryFile()  # noqa: SIM115  closed with the process
    settings = {
        "job": job,
        "arguments": arguments,
        "sites": _installed(),
        "cpu_s": limits.cpu_s,
        "memory_bytes": limits.memory_bytes,
        "channel": theirs.fileno(),
        "lifeline": alive,
    }
    try:
        child = subprocess.Popen(
            [sys.executable, "-I", str(CHILD), json.dumps(settings)],
            cwd="/",
            env=os.environ | ONE_THREAD,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=stderr,
            pass_fds=(theirs.fileno(), alive),
            start_new_session=True,  # an interrupt at the keyboard is ours to handle
        )
    finally:
        theirs.close()
        os.close(alive)
    return _Process(child, ours, lifeline, stderr)


def _installed() -> list[str]:
    """Folders of installed packages on this process's path; the current one and a script's are none."""
    return [site for site in sys.path if Path(site).name in ("site-packages", "dist-packages")]


def _cpu_s(pid: int) -> float:
    """Seconds that a process has computed; 0 where the system does not say."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")  # utime, stime: proc(5)


def _raise(kind: str, text: str, limits: Limits) -> NoReturn:
    """The exception that the job told of."""
    if kind == MemoryError.__name__:
        raise _out_of_memory(limits)
    own = getattr(errors, kind, None) if kind.isidentifier() else None
    if isinstance(own, type) and issubclass(own, errors.PerfQRError):
        raise own(text)
    raise Failed(" ".join(text.split())[:160])


def _out_of_memory(limits: Limits) -> OutOfMemory:
    return OutOfMemory(f"needs more than {limits.memory_bytes / 1e9:.1f} GB of memory")
