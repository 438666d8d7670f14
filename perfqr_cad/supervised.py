"""A run in a process of its own: a signal, or a crash of native code, ends it at once and leaves nothing.

Python acts on a signal only between two of its own instructions; the modeller and the solvers can take
seconds in between. The supervisor does no work and always answers.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from types import FrameType

from perfqr_cad import scratch

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
BAD_INPUT = 2  # exit code of a refusal
CRASHED = 70  # exit code of a crash in native code; EX_SOFTWARE of sysexits.h

_is_child = False  # whether this process is the one that works for a supervisor


def run(work: Callable[[], int]) -> int:
    """The exit code of `work`, done in a child process: 128 + n after a signal n that ends programs.

    A child that dies of a signal of its own, such as a segmentation fault, gives one line and `CRASHED`.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    parent = os.getpid()
    child = os.fork()
    if child == 0:
        _work(work, parent)
    signalled: list[int] = []

    def end(number: int, _: FrameType | None) -> None:
        signalled.append(number)
        scratch.settle(child)
        _kill(child)

    before = {number: signal.signal(number, end) for number in ENDING}
    _, status = os.waitpid(child, 0)
    for number, handler in before.items():
        signal.signal(number, handler)
    _kill(child)  # what it started and left behind
    scratch.clear(child)
    if signalled:
        return 128 + signalled[0]
    if os.WIFSIGNALED(status):
        name = signal.Signals(os.WTERMSIG(status)).name
        print(f"error: native code ended the program ({name}); nothing was written", file=sys.stderr)
        return CRASHED
    return os.WEXITSTATUS(status)


def is_child() -> bool:
    """Whether this process works for a supervisor, which takes interrupts at the keyboard in its stead."""
    return _is_child


def give_up(line: str, code: int) -> None:
    """End the program with a last line, from code that lets no exception through; nothing happens where the
    process is not that of the command, but of a program that uses this package."""
    if _is_child:
        print(line, file=sys.stderr, flush=True)
        os._exit(code)


def _work(work: Callable[[], int], parent: int) -> None:
    """The child's life, in a process group of its own: the terminal's Ctrl-C reaches the supervisor alone."""
    global _is_child
    os.setpgid(0, 0)
    _is_child = True
    _die_with_parent()
    if os.getppid() != parent:  # it died before it could be watched
        os._exit(1)
    code = 1
    try:
        code = work()
        sys.stdout.flush()
    finally:
        kind, error, trace = sys.exc_info()
        if kind is not None and error is not None:
            sys.excepthook(kind, error, trace)
        sys.stderr.flush()
        os._exit(code)


def _die_with_parent() -> None:
    """Ask Linux for SIGKILL when the supervisor dies, even by SIGKILL."""
    if sys.platform == "linux":
        import ctypes

        set_parent_death_signal = 1  # PR_SET_PDEATHSIG, linux/prctl.h
        ctypes.CDLL(None).prctl(set_parent_death_signal, signal.SIGKILL)


def _kill(child: int) -> None:
    try:
        os.killpg(child, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):  # gone already
        return
