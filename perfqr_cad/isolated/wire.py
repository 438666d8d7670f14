"""What goes between this process and an isolated one: plain values as JSON, arrays as their bytes.

Nothing that is received can run code here: no pickles, numbers only, within a limit of bytes.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Send = Callable[[bytes | memoryview], object]
Fill = Callable[[memoryview], None]  # fills a buffer with what comes, or raises

_LENGTH = struct.Struct("!I")
_NUMBERS = re.compile(r"[|<>][buif][1248]")  # booleans, integers and floats
MOST_HEADER_BYTES = 2**26


@dataclass(frozen=True)
class Message:
    """A value that JSON can hold, and arrays of numbers."""

    value: Any = None
    arrays: tuple[NDArray[Any], ...] = ()


def send(message: Message, write: Send) -> None:
    """Write a message: the length of a header, the header, the arrays."""
    arrays = [np.ascontiguousarray(array) for array in message.arrays]
    shapes = [(array.dtype.str, array.shape) for array in arrays]
    header = json.dumps({"value": message.value, "arrays": shapes}).encode()
    write(_LENGTH.pack(len(header)) + header)
    for array in arrays:
        if array.size:
            write(array.data.cast("B"))


def receive(fill: Fill, most_bytes: int) -> Message:
    """Read a message. ValueError if it is none, or larger than `most_bytes`."""
    (length,) = _LENGTH.unpack(_filled(fill, _LENGTH.size))
    if length > MOST_HEADER_BYTES:
        raise ValueError(f"a header of {length} bytes")
    try:
        header = json.loads(_filled(fill, length))
        kinds = [(str(kind), tuple(int(n) for n in shape)) for kind, shape in header["arrays"]]
    except (RecursionError, KeyError, TypeError) as error:
        raise ValueError(f"a header that is none ({error})") from error
    if not all(_NUMBERS.fullmatch(kind) and all(n >= 0 for n in shape) for kind, shape in kinds):
        raise ValueError("arrays that are no numbers")
    if sum(_size(kind, shape) for kind, shape in kinds) > most_bytes:
        raise ValueError(f"more than {most_bytes} bytes")
    return Message(header.get("value"), tuple(_array(fill, kind, shape) for kind, shape in kinds))


def _array(fill: Fill, kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    array = np.empty(shape, kind)
    if array.size:
        fill(array.data.cast("B"))
    return array


def _size(kind: str, shape: tuple[int, ...]) -> int:
    size = int(kind[2])
    for length in shape:
        size *= length
    return size


def _filled(fill: Fill, length: int) -> bytearray:
    buffer = bytearray(length)
    fill(memoryview(buffer))
    return buffer
