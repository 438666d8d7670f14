"""What the freedom of a code saves: pieces and bridges of ordinary symbols, of the best mask, and of ours."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from statistics import median
from time import process_time
from typing import Final

import numpy as np

from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.pattern.arrangement import Joining, joining
from perfqr_cad.pattern.cells.lattice import label
from perfqr_cad.pattern.choice import chosen, easiest
from perfqr_cad.symbol import Symbol, encode, free_codewords, with_pads
from perfqr_cad.symbol.layout import Role, layout
from perfqr_cad.table import Table

SIZE_MM: Final = 70.0
EVERYDAY: Final = (
    "https://example.com",
    "https://example.com/p/1234567",
    "https://www.example.org/catalogue/spare-parts?item=4711-0815",
    "WIFI:T:WPA;S:Workshop;P:correct horse battery;;",
    "BEGIN:VCARD\nVERSION:3.0\nN:Muster;Erika\nFN:Erika Muster\nTEL:+491701234567\nEND:VCARD",
    "SN-2024-000123456",
    "LOT 7731 / 2027-05",
    "tel:+41446681800",
    "geo:47.3769,8.5417",
    "mailto:info@example.com?subject=Hello",
)
VERSIONS: Final = (2, 5, 8, 12, 20, 30, 40)
FILLED: Final = (0.1, 0.3, 0.6, 0.9)  # of the data codewords
RANDOM_PADS: Final = 1000


def run() -> tuple[Table, Table]:
    """Everyday texts, and versions filled to several degrees."""
    return _everyday(), _filled()


def _everyday() -> Table:
    found = [_bridges(text) for text in EVERYDAY]
    rows = [(f"{text[:30]!r}", *row) for text, row in zip(EVERYDAY, found, strict=True)]
    middle = [median(counts) for counts in zip(*(row[:3] for row in found), strict=True)]
    return Table(
        f"freedom: bridges of everyday texts at {SIZE_MM:g} mm",
        ("text", "ordinary", "best mask", "ours", "ours / best mask", "versions", "codewords lost"),
        (*rows, ("median", *middle, middle[2] / middle[1], "", "")),
        ("at most a third of the best mask's is the aim",),
    )


def _bridges(text: str) -> tuple[int, int, int, float, str, int]:
    spec = PatternSpec(size_mm=SIZE_MM)
    masked = chosen(partial(encode, text), spec, free=frozenset({"mask"}))
    ours = chosen(partial(encode, text), spec)
    ordinary, by_mask, by_us = (build(one, spec) for one in (masked.plain, masked.symbol, ours.symbol))
    counts = [len(pattern.bridges) for pattern in (ordinary, by_mask, by_us)]
    versions = f"{masked.symbol.version} to {ours.symbol.version}"
    return counts[0], counts[1], counts[2], counts[2] / counts[1], versions, sum(by_us.readability.errors)


def _filled() -> Table:
    rows = [row for version in VERSIONS for share in FILLED for row in _rows(version, share)]
    return Table(
        "freedom: pieces and corners to be linked",
        ("version", "filled", "code", "pieces", "pieces by edges", "least", "corners", "of encoding"),
        tuple(rows),
        (
            "pieces: material that hangs together over edges and corners; by edges: over edges alone",
            "least: the frame and the light rings of finders and alignment patterns",
            f"level M; random pads: the best of {RANDOM_PADS} up to version 8",
        ),
    )


def _rows(version: int, share: float) -> Iterator[tuple[object, ...]]:
    spec = PatternSpec()
    size = max(1, round(share * encode("A", version=version).blocks.data_codewords) - 3)
    symbol = encode(np.random.default_rng(version).bytes(size), version=version)
    begin = process_time()
    encode("A", version=version)
    encoding_s = max(process_time() - begin, 1e-4)
    least = 4 + len(_alignment_rings(symbol))
    begin = process_time()
    ours, left = easiest(symbol, spec)
    ratio = (process_time() - begin) / encoding_s
    masked, left_masked = easiest(symbol, spec, pads=False)
    plain = joining(symbol, False, 4)
    found: list[tuple[str, Symbol, Joining, float | None]] = [("ordinary", symbol, plain, None)]
    found.append(("best mask", masked, left_masked, None))
    if version <= 8:
        found.append(("random pads", *_best_of_random(masked), None))
    found.append(("ours", ours, left, ratio))
    for name, one, remains, took in found:
        edges = label(np.pad(~one.matrix.dark, 4, constant_values=True))[1]
        yield version, share, name, remains.count, edges, least, len(remains.corners), took


def _alignment_rings(symbol: Symbol) -> list[tuple[int, int]]:
    """Centres of alignment patterns."""
    is_ring = layout(symbol.version, symbol.level).roles == Role.ALIGNMENT
    whole = np.lib.stride_tricks.sliding_window_view(is_ring, (5, 5)).all(axis=(2, 3))
    return [(int(row), int(column)) for row, column in np.argwhere(whole)]


def _best_of_random(symbol: Symbol) -> tuple[Symbol, Joining]:
    random = np.random.default_rng(0)
    pads = (random.bytes(free_codewords(symbol)) for _ in range(RANDOM_PADS))
    tried = ((one, joining(one, False, 4)) for one in (with_pads(symbol, pad) for pad in pads))
    return min(tried, key=lambda one: one[1].area)
