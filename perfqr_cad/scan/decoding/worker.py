"""What runs in the panel's processes: the native decoders, each loaded and tried once."""

from __future__ import annotations

import sys

import numpy as np

from perfqr_cad.isolated import Message
from perfqr_cad.scan.decoding import decoders
from perfqr_cad.scan.decoding.decoders import Reader

BLANK = np.full((64, 64), 255, np.uint8)


class Readers:
    """The engines of those names that can be loaded here.

    It answers `{"decoder": name}` with a gray picture (H, W) uint8 by the payloads, in hexadecimal. `report`
    is why engines could not be loaded, by name.
    """

    def __init__(self, *names: str) -> None:
        self.report: dict[str, str] = {}
        self._readers: dict[str, Reader] = {}
        for name in names:
            try:
                reader = decoders.load(name)
                reader(BLANK.copy())  # what an engine loads with its first picture is loaded now
            except Exception as error:  # noqa: BLE001  an engine that is broken here, however, is left out
                self.report[name] = " ".join(str(error).split()) or type(error).__name__
            else:
                self._readers[name] = reader

    def __call__(self, request: Message) -> Message:
        """What one engine reads in one picture; some engines write into their input, which is their own."""
        (image,) = request.arrays
        try:
            payloads = self._readers[request.value["decoder"]](image)
        except EOFError as error:  # the engine's own process has ended: so does this one, to be replaced
            sys.exit(str(error))
        return Message([payload.hex() for payload in payloads])
