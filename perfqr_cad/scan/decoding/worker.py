"""The process in which native decoders run: `python -m perfqr_cad.scan.decoding.worker NAME...`.

Protocol on standard input and output. Once every engine is loaded the worker writes a line `ready`.
A request is a JSON line `{"decoder", "height", "width"}` and height x width bytes of gray; the answer
is a JSON line with the payloads in hexadecimal. The parent ends it by closing its input.
"""

from __future__ import annotations

import json
import os
import sys
from typing import BinaryIO

import numpy as np

from perfqr_cad.scan.decoding import decoders


def private_stdout() -> BinaryIO:
    """Keep the answer channel for ourselves: native libraries that print must not write into it."""
    channel = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return channel


def serve(names: list[str], requests: BinaryIO, answers: BinaryIO) -> None:
    """Answer requests until the input ends."""
    readers = {name: decoders.load(name) for name in names}
    answers.write(b"ready\n")
    answers.flush()
    while header := requests.readline():
        request = json.loads(header)
        shape = request["height"], request["width"]
        pixels = requests.read(shape[0] * shape[1])
        image = np.frombuffer(pixels, np.uint8).reshape(shape)
        payloads = readers[request["decoder"]](image.copy())  # some engines write into their input
        answers.write(json.dumps([payload.hex() for payload in payloads]).encode() + b"\n")
        answers.flush()


if __name__ == "__main__":
    serve(sys.argv[1:], sys.stdin.buffer, private_stdout())
