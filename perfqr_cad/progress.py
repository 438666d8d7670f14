"""Who is told which step is running. Silent unless somebody listens."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[str], None]

_listener: ContextVar[Listener | None] = ContextVar("perfqr_progress", default=None)


@contextmanager
def listening(listener: Listener) -> Generator[None]:
    """Call `listener` with the name of every step begun inside the block."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def tell(step: str) -> None:
    """Announce the step that starts now."""
    listener = _listener.get()
    if listener is not None:
        listener(step)


BAR = 20  # characters


def counter(step: str, total: int) -> Callable[[int], None]:
    """What announces how many of `total` are done, as a bar. It may be called from any thread."""
    listener = _listener.get()

    def announce(done: int) -> None:
        if listener is not None:
            full = BAR * done // max(total, 1)
            listener(f"{step} {'█' * full}{'░' * (BAR - full)} {done}/{total}")

    return announce
