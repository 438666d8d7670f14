"""Speed of the symbol layer beside segno, which is also plain Python."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np

from perfqr_cad.symbol import Matrix, ReadabilityTracker, Symbol, encode, layout, readability, recover
from perfqr_cad.table import Table

TEXT = "https://example.com/p/1234567"
VERSIONS = (5, 8, 20, 40)
LEVEL = "M"


def run() -> Table:
    """Median times at four versions, and each as a multiple of segno's time for the same symbol."""
    rows = [row for version in VERSIONS for row in _rows(version)]
    return Table(
        "symbol",
        ("version", "task", "ms", "of segno's encoding"),
        tuple(rows),
        (
            f"level {LEVEL}; medians of runs on this machine, the ratio is what compares",
            "damaged: r wrong codewords in every block; shaded: 5 more, all of them marked as doubtful",
        ),
    )


def _rows(version: int) -> list[tuple[int, str, float, float]]:
    import segno

    symbol = encode(TEXT, version=version, level=LEVEL)
    capacity = symbol.blocks.capacity
    damaged, shaded = _damaged(symbol, capacity), _damaged(symbol, capacity + 5)
    doubt = np.where(shaded.dark, 1.0, -1.0) * np.where(shaded.dark ^ symbol.matrix.dark, 0.1, 5.0)
    tracker = ReadabilityTracker(symbol)
    row, column = (int(k) for k in layout(version, LEVEL).modules[0, 0])
    tasks: dict[str, Callable[[], object]] = {
        "encode, best of 8 masks": lambda: encode(TEXT, version=version, level=LEVEL),
        "recover, clean": lambda: recover(symbol.matrix),
        "recover, damaged": lambda: recover(damaged),
        "recover, shaded": lambda: recover(shaded, log_likelihood=doubt),
        "L(Q) in full": lambda: readability(damaged, symbol),
        "L(Q) after one module": lambda: (tracker.flip(row, column), tracker.total),
        "L(Q) preview of one module": lambda: tracker.preview([(row, column)]),
    }
    unit = _median_ms(lambda: segno.make(TEXT, version=version, error=LEVEL, boost_error=False))
    times = {name: _median_ms(task) for name, task in tasks.items()}
    return [(version, name, time, time / unit) for name, time in times.items()]


def _damaged(symbol: Symbol, count: int) -> Matrix:
    """One wrong module in the first `count` codewords of each block."""
    at = layout(symbol.version, symbol.level)
    chosen = np.concatenate([group[:, :count].ravel() for group in at.groups])
    return symbol.matrix.flipped(at.modules[chosen, 0])


def _median_ms(task: Callable[[], object], least_seconds: float = 0.1) -> float:
    """Median time of a call over at least three calls and a tenth of a second."""
    times: list[float] = []
    task()
    while len(times) < 3 or sum(times) < least_seconds:
        start = perf_counter()
        task()
        times.append(perf_counter() - start)
    return 1e3 * float(np.median(times))
