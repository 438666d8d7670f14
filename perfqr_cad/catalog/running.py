"""Running a template's `build(p)`: somebody's code, whatever it does, ends in a design or in one line."""

from __future__ import annotations

import runpy
import signal
import threading
import time
import traceback
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import TYPE_CHECKING

from perfqr_cad import supervised
from perfqr_cad.errors import PerfQRError, TemplateError
from perfqr_cad.pipeline.kinds import Value, shown

if TYPE_CHECKING:
    from perfqr_cad.pipeline.design import Design

# Seconds that a template's own code may compute, or wait; shipped ones take up to 3, nearly all imports.
TIMEOUT_S = 60.0
_TICK_S = 0.25  # between two looks at what is running
_IDLE = 0.002  # share of the time that code which waits computes; a busy machine leaves others more
_STRIKES = 8  # times that the end may be swallowed


class _TooLong(BaseException):
    """Not an `Exception`, which templates catch. Where all is caught it comes again at each look."""


def run(path: Path, values: Mapping[str, Value], timeout_s: float) -> Design:
    """The design that the template makes of the values. Raises `TemplateError` for all else that it does."""
    from perfqr_cad.pipeline.design import Design

    if not timeout_s > 0:
        raise TemplateError(f"a time limit of {timeout_s:g} s lets no template run: give seconds above 0")
    too_long = (
        f"{path.name} computes or waits for {timeout_s:g} s without an end: simplify it, or raise "
        "--template-timeout"
    )
    try:
        with _limited(timeout_s, too_long):
            build = runpy.run_path(str(path), run_name=f"perfqr_template_{path.stem}").get("build")
            if build is None:
                raise TemplateError(f"{path.name} takes its build(p) away: keep it")
            made = build(SimpleNamespace(**values))
    except PerfQRError:
        raise
    except _TooLong:
        raise TemplateError(too_long) from None
    except (SystemExit, KeyboardInterrupt) as error:
        if isinstance(error, KeyboardInterrupt) and not supervised.is_child():
            raise  # somebody's own
        raise TemplateError(f"{path.name}{_line(path, error)} ends the program: return a Design") from error
    except Exception as error:
        raise TemplateError(f"{path.name}{_line(path, error)}: {type(error).__name__}: {error}") from error
    if not isinstance(made, Design):
        what = "nothing" if made is None else f"{shown(made)}, which is no Design"
        raise TemplateError(f"build(p) of {path.name} returns {what}: return what make() returns")
    return made


def _line(path: Path, error: BaseException) -> str:
    """The innermost line of the template that led to the error."""
    lines = [
        frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)
    ]
    return f" line {lines[-1]}" if lines else ""


@contextmanager
def _limited(timeout_s: float, too_long: str) -> Generator[None]:
    """End the block after so many seconds of computing, or of waiting in one go; time inside `make` is free.

    A busy machine does not change what a template may do: seconds of the CPU count, and those in which hardly
    any are used. Code that swallows its end several times ends the program with `too_long`, where it is the
    command's own. Only the main thread can be interrupted: elsewhere, and on Windows, nothing is limited.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return
    own = _OwnTime()
    strikes = 0

    def look(_: int, frame: FrameType | None) -> None:
        nonlocal strikes
        own.count(frame)
        if max(own.computed_s, own.waited_s) > timeout_s:
            strikes += 1
            if strikes > _STRIKES:
                supervised.give_up(f"error: {too_long}", supervised.BAD_INPUT)
            raise _TooLong

    before = signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, _TICK_S, _TICK_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


class _OwnTime:
    """Seconds that a template's own code has computed, and has waited since it last computed."""

    def __init__(self) -> None:
        self.computed_s, self.waited_s = 0.0, 0.0
        self._cpu_s, self._clock_s = time.process_time(), time.monotonic()

    def count(self, frame: FrameType | None) -> None:
        """Add what has passed since the last look, while `frame` is run."""
        from perfqr_cad.pipeline import chain

        cpu_s, clock_s = time.process_time(), time.monotonic()
        worked_s, passed_s = cpu_s - self._cpu_s, clock_s - self._clock_s
        self._cpu_s, self._clock_s = cpu_s, clock_s
        if _within(frame, chain.__file__):
            self.waited_s = 0.0
            return
        self.computed_s += worked_s
        self.waited_s = self.waited_s + passed_s if worked_s < _IDLE * passed_s else 0.0


def _within(frame: FrameType | None, filename: str) -> bool:
    """Whether a function of that file is being run."""
    while frame is not None:
        if frame.f_code.co_filename == filename:
            return True
        frame = frame.f_back
    return False
