"""The one way in for files that a user names: what they are and how large is known before they are read.

Only a regular file is opened, through links too: a folder, pipe, socket or device never is. What a file holds
is the business of those who read it; native parsers do that in a process of their own (`isolated`).
"""

from __future__ import annotations

import json
import os
import re
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from perfqr_cad.errors import PerfQRError

MIB = 2**20
MAX_JSON_DEPTH = 64  # a certificate nests 6 deep
_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
_JSON_MARKS = re.compile(r'"(?:[^"\\]|\\.)*"|[\[{]|[\]}]')


def read_bytes(path: str | Path, most_bytes: int, error: type[PerfQRError], noun: str) -> bytes:
    """The content of a regular file of at most `most_bytes`.

    Raises `error` with one line that calls for `noun`, such as "a STEP file", where there is none.

    >>> read_bytes("/dev/zero", 100, PerfQRError, "a picture file")
    Traceback (most recent call last):
    perfqr_cad.errors.PerfQRError: /dev/zero is a device, not a file: name a picture file
    """
    try:
        _require_file(os.stat(path).st_mode, path, error, noun)  # opening a device or a pipe has effects
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            found = os.fstat(file.fileno())
            _require_file(found.st_mode, path, error, noun)  # it may be another one by now
            content = b"" if found.st_size > most_bytes else file.read(most_bytes + 1)
    except (OSError, ValueError) as failure:  # ValueError: a name with a zero byte
        reason = getattr(failure, "strerror", None) or str(failure)
        raise error(f"{_shown(path)} cannot be read ({reason}): name {noun} that can be read") from failure
    size = max(found.st_size, len(content))
    if size > most_bytes:
        raise error(
            f"{_shown(path)} has {size:,} bytes or more, the limit is {most_bytes:,}: name {noun} within it"
        )
    return content


def read_text(path: str | Path, most_bytes: int, error: type[PerfQRError], noun: str) -> str:
    """The text of a regular file in UTF-8, with or without a byte order mark; errors as `read_bytes`."""
    try:
        return read_bytes(path, most_bytes, error, noun).decode("utf-8-sig")
    except UnicodeDecodeError as failure:
        raise error(
            f"{_shown(path)} is no text in UTF-8 (byte {failure.start:,} is none): save it in that encoding"
        ) from failure


def read_json(
    path: str | Path,
    most_bytes: int,
    error: type[PerfQRError],
    noun: str,
    numbers: Callable[[str], Any] | None = None,
) -> Any:
    """The value of a JSON file that nests at most `MAX_JSON_DEPTH` values; errors as `read_bytes`.

    numbers   makes values of numbers as they are written; None: floats and integers
    """
    text = read_text(path, most_bytes, error, noun)
    if _deeper_than(MAX_JSON_DEPTH, text):
        raise error(f"{_shown(path)} nests more than {MAX_JSON_DEPTH} values, the limit: name {noun}")
    try:
        return json.loads(text, parse_int=numbers, parse_float=numbers, parse_constant=_no_constant)
    except ValueError as failure:
        raise error(f"{_shown(path)} is no JSON ({failure}): name {noun}") from failure


def _require_file(mode: int, path: str | Path, error: type[PerfQRError], noun: str) -> None:
    if not stat.S_ISREG(mode):
        kind = next((name for is_one, name in _KINDS if is_one(mode)), "something else")
        raise error(f"{_shown(path)} is {kind}, not a file: name {noun}")


def _no_constant(word: str) -> NoReturn:
    raise ValueError(f"{word} is none")


def _shown(path: str | Path) -> str:
    """A path for a message: names of hundreds of letters are cut."""
    text = str(path).replace("\0", "\\0")
    return text if len(text) <= 200 else f"{text[:100]}…{text[-50:]}"


def _deeper_than(limit: int, text: str) -> bool:
    """Whether brackets outside of strings nest more than `limit` deep."""
    depth = 0
    for mark in _JSON_MARKS.finditer(text):
        opens = mark.group()[0]
        depth += 1 if opens in "[{" else -1 if opens in "]}" else 0
        if depth > limit:
            return True
    return False
