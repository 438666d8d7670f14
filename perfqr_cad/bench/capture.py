"""Pictures read by this package beside the decoders it is measured against."""

from __future__ import annotations

import csv
import importlib.util
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture import load_image, read
from perfqr_cad.capture.pictures.image import luminance
from perfqr_cad.errors import CaptureError
from perfqr_cad.scan.decoding import decoders
from perfqr_cad.table import Table

CHECKOUT = Path(__file__).resolve().parents[2]
SHARED = CHECKOUT.parent / "shared" / "data"
GENERATED_SEEDS = range(2)  # each makes 23 pictures
OURS = "perfqr"
UNION = "any of the four"

Picture = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class PictureCase:
    """A picture, the group it is counted in, and what makes a payload right."""

    group: str
    picture: Picture
    is_right: Callable[[bytes], bool]


def run() -> Table:
    """Pictures read, payloads right and wrong, and median times, by group of pictures and reader."""
    readers = {OURS: _ours, **{name: _decoder(name) for name in decoders.CORE}}
    results: dict[tuple[str, str], list[tuple[bool, bool, float]]] = {}
    for case in _pictures():
        outcomes = {name: _outcome(reader, case) for name, reader in readers.items()}
        right = any(outcomes[name][0] for name in decoders.CORE)
        read_any = any(outcomes[name][1] for name in decoders.CORE)
        outcomes[UNION] = (right, read_any, sum(outcomes[name][2] for name in decoders.CORE))
        for name, outcome in outcomes.items():
            results.setdefault((case.group, name), []).append(outcome)
    rows = [_row(*key, outcomes) for key, outcomes in results.items()]
    return Table(
        "capture: pictures read",
        ("pictures", "reader", "of", "read", "right", "wrong", "median ms"),
        tuple(rows),
        (
            "wrong: payloads read, none of which is the right one",
            "the decoders get the luminance that this package reads from the file; perfqr's time is that of "
            "the whole capture, with its art",
        ),
    )


def _row(group: str, name: str, outcomes: list[tuple[bool, bool, float]]) -> tuple[Any, ...]:
    seen = sum(found for _, found, _ in outcomes)
    right = sum(right for right, _, _ in outcomes)
    time_ms = median(seconds for _, _, seconds in outcomes) * 1000
    return group, name, len(outcomes), seen, right, seen - right, round(time_ms, 1)


def _outcome(reader: Callable[[Picture], tuple[bytes, ...]], case: PictureCase) -> tuple[bool, bool, float]:
    """Whether the right payload was read, whether any was, and the seconds it took."""
    start = perf_counter()
    payloads = reader(case.picture)
    return any(case.is_right(one) for one in payloads), bool(payloads), perf_counter() - start


def _ours(picture: Picture) -> tuple[bytes, ...]:
    try:
        return (read(picture).recovery.payload.data,)
    except CaptureError:
        return ()


def _decoder(name: str) -> Callable[[Picture], tuple[bytes, ...]]:
    engine = decoders.load(name)
    return lambda picture: engine(luminance(picture))


def _pictures() -> Iterator[PictureCase]:
    yield from _shared()
    yield from _generated()


def _shared() -> Iterator[PictureCase]:
    """The pictures beside the checkout, when they are there."""
    if not (SHARED / "MANIFEST.csv").exists():
        return
    with (SHARED / "MANIFEST.csv").open(newline="") as manifest:
        for row in csv.DictReader(manifest):
            if row["file"].startswith("art/"):
                start = row["payload_starts_with"].encode()
                yield PictureCase("artistic, shared", load_image(SHARED / row["file"]), _begins_with(start))
    for path in sorted((SHARED / "photos").glob("*.png")):
        expected = decoders.accepted(path.with_suffix(".txt").read_bytes())
        yield PictureCase("photographs, shared", load_image(path), expected.__contains__)


def _begins_with(start: bytes) -> Callable[[bytes], bool]:
    return lambda data: data.startswith(start)


def _generated() -> Iterator[PictureCase]:
    """Pictures by the generators of the tests, when the checkout and the generators are there."""
    source = CHECKOUT / "tests" / "pictures.py"
    present = source.exists() and all(map(importlib.util.find_spec, ("qrtsy", "pyqart", "qrcode")))
    spec = importlib.util.spec_from_file_location("perfqr_test_pictures", source) if present else None
    if spec is None or spec.loader is None:
        return
    pictures = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = pictures  # dataclasses look their module up there
    spec.loader.exec_module(pictures)
    for seed in GENERATED_SEEDS:
        for place, sample in enumerate(pictures.corpus(seed)):
            group = "artistic, generated" if place < pictures.ARTISTIC_OF_CORPUS else "distorted, generated"
            yield PictureCase(group, sample.picture, sample.is_right)
