"""Code that is not ours, or meets files that are not ours, runs in processes of their own.

Parsers and decoders crash, never end or take all memory on some inputs. Each runs in a process that is
started isolated (`python -I`: no code from the current folder or from PYTHONPATH), and is bounded in memory
and in work. What it sends back is data: plain values and arrays.

A job is a function named by its place, `package.module:function`. It is called once, in that process, with
plain arguments: it imports what it needs and returns the function that answers a `Message` by a `Message`.
"""

from .child import without_files
from .wire import Message
from .worker import (
    Crashed,
    Failed,
    IsolationError,
    Limits,
    OutOfMemory,
    OutOfTime,
    Refusal,
    Worker,
    kept,
    once,
)

__all__ = [
    "Crashed",
    "Failed",
    "IsolationError",
    "Limits",
    "Message",
    "OutOfMemory",
    "OutOfTime",
    "Refusal",
    "Worker",
    "kept",
    "once",
    "without_files",
]
