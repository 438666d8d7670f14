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

from perfqr_cad.errors import PerfQRError, TemplateError
from perfqr_cad.pipeline.kinds import Value, shown

if TYPE_CHECKING:
    from perfqr_cad.pipeline.design import Design

TIMEOUT_S = 60.0  # CPU seconds of a template's own code; shipped ones take up to 3, nearly all of it imports
_TICK_S = 0.25  # CPU seconds between two looks at what is running


class _TooLong(BaseException):
    """Not an `Exception`, so that a template which catches those does not go on for ever."""


def run(path: Path, values: Mapping[str, Value], timeout_s: float) -> Design:
    """The design that the template makes of the values. Raises `TemplateError` for all else that it does."""
    from perfqr_cad.pipeline.design import Design

    if not timeout_s > 0:
        raise TemplateError(f"a time limit of {timeout_s:g} s lets no template run: give CPU seconds above 0")
    try:
        with _limited(timeout_s):
            build = runpy.run_path(str(path), run_name=f"perfqr_template_{path.stem}").get("build")
            if build is None:
                raise TemplateError(f"{path.name} takes its build(p) away: keep it")
            made = build(SimpleNamespace(**values))
    except PerfQRError:
        raise
    except _TooLong:
        raise TemplateError(
            f"{path.name} ran for {timeout_s:g} s without an end: simplify it, or raise --template-timeout"
        ) from None
    except SystemExit as error:
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
def _limited(timeout_s: float) -> Generator[None]:
    """End the block after so many CPU seconds of this process; those spent inside `make` do not count.

    CPU time, so that a busy machine does not change what a template may do. Only the main thread can be
    interrupted: elsewhere, and on Windows, nothing is limited.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return
    from perfqr_cad.pipeline import chain

    spent_s, last_s = 0.0, time.process_time()

    def look(_: int, frame: FrameType | None) -> None:
        nonlocal spent_s, last_s
        now_s = time.process_time()
        spent_s, last_s = spent_s + (0.0 if _within(frame, chain.__file__) else now_s - last_s), now_s
        if spent_s > timeout_s:
            raise _TooLong

    before = signal.signal(signal.SIGPROF, look)
    signal.siginterrupt(signal.SIGPROF, False)
    signal.setitimer(signal.ITIMER_PROF, _TICK_S, _TICK_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def _within(frame: FrameType | None, filename: str) -> bool:
    """Whether a function of that file is being run."""
    while frame is not None:
        if frame.f_code.co_filename == filename:
            return True
        frame = frame.f_back
    return False
