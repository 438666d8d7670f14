"""A STEP file before the modeller reads it: its size, its marks, how deep it nests, how many records it has.

The modeller's parser works by recursion and keeps every record. Without the modeller, so that one may look
before it is loaded.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from perfqr_cad.bounded import MIB, read_bytes
from perfqr_cad.errors import KernelError
from perfqr_cad.isolated import Message, Refusal, once

MAX_BYTES = 256 * MIB
MAX_RECORDS = 4_000_000  # each takes the modeller some 300 bytes
MAX_DEPTH = 100  # of parentheses; a list of lists in a typed parameter has 4
MAGIC, END = b"ISO-10303-21", b"END-ISO-10303-21;"
ENVELOPE_BYTES = 512  # at either end of the file, where its marks are looked for
AGAIN = "export it again as STEP AP203, AP214 or AP242"
_STRING = re.compile(rb"'[^']*'")


def step_content(path: str | Path) -> bytes:
    """The bytes of a STEP file. `KernelError` for one that is missing, too large, not STEP or cut short."""
    content, name = read_bytes(path, MAX_BYTES, KernelError, "a STEP file"), Path(path).name
    if MAGIC not in content[:ENVELOPE_BYTES]:
        raise KernelError(f"{name} is not a STEP file (no {MAGIC.decode()} header): {AGAIN}")
    if END not in content[-ENVELOPE_BYTES:]:
        raise KernelError(
            f"{name} is cut short after {len(content)} bytes (no end mark): copy it again or {AGAIN}"
        )
    return content


def ask(job: str, path: str | Path, *arguments: Any) -> Message:
    """What a job makes of a STEP file in a process of its own, called with the file's name and `arguments`.

    `KernelError` if the file is none, or if the modeller crashes on it or does not end within limits.
    """
    content, name = step_content(path), Path(path).name
    return once(
        job,
        (name, *arguments),
        Message(None, (np.frombuffer(content, np.uint8),)),
        Refusal(KernelError, f"{name} cannot be read", AGAIN),
    )


def require_readable(content: bytes, name: str) -> None:
    """`KernelError` for what the modeller's parser must not meet."""
    plain = np.frombuffer(_STRING.sub(b"", content), np.uint8)
    records = int(np.count_nonzero(plain == ord(";")))
    if records > MAX_RECORDS:
        raise KernelError(f"{name} has {records:,} records, the limit is {MAX_RECORDS:,}: simplify the part")
    signs = plain[(plain == ord("(")) | (plain == ord(")"))]
    steps = np.where(signs == ord("("), np.int8(1), np.int8(-1))
    depth = int(np.cumsum(steps, dtype=np.int64).max(initial=0))
    if depth > MAX_DEPTH:
        raise KernelError(f"{name} nests {depth:,} parentheses, the limit is {MAX_DEPTH}: {AGAIN}")
