"""This side: a process that does one job, started when it is first asked and again after it has died."""

from __future__ import annotations

import atexit
import os
import signal
import threading
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any, NoReturn

from numpy.typing import NDArray

from perfqr_cad import errors
from perfqr_cad.isolated import wire
from perfqr_cad.isolated.process import MAX_WORDS, STALL_S, Process
from perfqr_cad.isolated.wire import Message

NEARLY = 0.9  # of the limit of memory: native code that dies there has been refused more
# What a C++ or Rust library says when there is no memory, before it gives up.
NO_MEMORY = ("bad_alloc", "memory allocation of", "out of memory", "MemoryError", "Cannot allocate memory")


@dataclass(frozen=True)
class Limits:
    """Bounds of one answer: seconds of computing, and bytes of the process's own memory.

    Work is counted, not time: a busy machine changes no result. The defaults are for reading a file: with
    what this process itself takes, one that is refused costs no more than 60 s and 2 GB.
    """

    cpu_s: float = 50.0
    memory_bytes: int = 1536 * 2**20


# Environment variables: seconds of computing and gigabytes of memory that reading one file may take.
READING_S, READING_GB = "PERFQR_READING_S", "PERFQR_READING_GB"
MOST_ALLOWED = 86_400.0  # a day


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


class Worker:
    """A job in a process of its own. `ask` may be called from several threads; answers come one by one."""

    def __init__(self, job: str, *arguments: Any, limits: Limits = Limits()) -> None:
        """`job` is `package.module:function` (or `/absolute/file.py:function`), called with `arguments`."""
        self._job, self._arguments, self._limits = job, arguments, limits
        self._lock = threading.RLock()
        self._process: Process | None = None
        self._report: Any = None

    def start(self) -> None:
        """Start the process without waiting for it."""
        with self._lock:
            if self._process is not None and self._process.owner != os.getpid():
                self._process.close()  # it is our parent's: we are a fork
                self._process = None
            if self._process is None:
                self._process = Process.started(
                    {"job": self._job, "arguments": self._arguments} | asdict(self._limits)
                )

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
            kind, told = answer.value["error"]
            _raise(kind, told, self._limits)
        return Message(answer.value["answer"], answer.arrays)

    def stop(self) -> None:
        """End the process, whatever it is doing; who waits for an answer is told that it crashed."""
        process = self._process
        if process is None:
            return
        if process.owner == os.getpid():
            process.kill()
        with self._lock:
            self._forget()

    def _running(self) -> Process:
        self.start()
        process = self._process
        assert process is not None
        if not process.ready:
            self._report = self._exchange(process).value["ready"]
            process.ready = True
        return process

    def _exchange(self, process: Process, request: Message | None = None) -> Message:
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

    def _reason(self, process: Process, error: Exception) -> IsolationError:
        """Why a process gave no answer."""
        if isinstance(error, TimeoutError):
            return OutOfTime(f"nothing happened for {STALL_S:g} s")
        if isinstance(error, ValueError):
            return Crashed(f"answered {error}")
        code = process.exit_code()
        words = process.last_words()
        if code == -signal.SIGPROF:
            return OutOfTime(f"no end after {self._limits.cpu_s:g} s of computing")
        full = process.peak_bytes > NEARLY * self._limits.memory_bytes
        if any(sign in words for sign in NO_MEMORY) or (code < 0 and full):
            return _out_of_memory(self._limits)
        how = f"crashed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        return Crashed(f"{how}: {words}" if words else how)


@dataclass(frozen=True)
class Refusal:
    """The line for what cannot be read: "`what` (reason): `remedy`", as an `error`."""

    error: type[errors.PerfQRError]
    what: str
    remedy: str

    def of(self, reason: IsolationError) -> errors.PerfQRError:
        """The error for a reason. What meets a limit is too much, whatever else may be wrong with it."""
        match reason:
            case OutOfTime():
                remedy = f"simplify it, or allow more seconds by the variable {READING_S}"
            case OutOfMemory():
                remedy = f"simplify it, or allow more gigabytes by the variable {READING_GB}"
            case _:
                remedy = self.remedy
        return self.error(f"{self.what} ({reason}): {remedy}")


def once(job: str, arguments: tuple[Any, ...], request: Message, refusal: Refusal) -> Message:
    """The answer of a process that is started for it, within `reading_limits`.

    Raises `PerfQRError`: the job's own, or the `refusal`.
    """
    worker = Worker(job, *arguments, limits=reading_limits())
    try:
        return worker.ask(request.value, *request.arrays)
    except IsolationError as reason:
        raise refusal.of(reason) from reason
    finally:
        worker.stop()


def reading_limits() -> Limits:
    """Bounds for reading one file: the usual, or what the environment allows. DesignError for none."""
    usual = Limits()
    return Limits(
        cpu_s=_allowed(READING_S, usual.cpu_s),
        memory_bytes=int(_allowed(READING_GB, usual.memory_bytes / 1e9) * 1e9),
    )


def _allowed(variable: str, usual: float) -> float:
    text = os.environ.get(variable)
    if not text:
        return usual
    try:
        allowed = float(text)
    except ValueError:
        allowed = 0.0
    if not 0 < allowed <= MOST_ALLOWED:
        raise errors.DesignError(
            f"{variable}={text!r} is no number from 0 to {MOST_ALLOWED:g}: give what reading a file may take"
        )
    return allowed


@cache
def kept(job: str, *arguments: Any, limits: Limits = Limits()) -> Worker:
    """A worker that is kept for the life of this process, for short jobs that come often."""
    worker = Worker(job, *arguments, limits=limits)
    atexit.register(worker.stop)
    return worker


def _raise(kind: str, text: str, limits: Limits) -> NoReturn:
    """The exception that the job told of."""
    if kind == MemoryError.__name__:
        raise _out_of_memory(limits)
    own = getattr(errors, kind, None) if kind.isidentifier() else None
    if isinstance(own, type) and issubclass(own, errors.PerfQRError):
        raise own(text)
    raise Failed(" ".join(text.split())[:MAX_WORDS])


def _out_of_memory(limits: Limits) -> OutOfMemory:
    return OutOfMemory(f"needs more than {limits.memory_bytes / 1e9:.1f} GB of memory")
