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
