"""Speed of the symbol layer beside segno, which is also plain Python."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Final

import numpy as np

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol import Level, Matrix, ReadabilityTracker, Symbol, encode, layout, readability, recover
from perfqr_cad.table import Table

TEXT = "https://example.com/p/1234567"
VERSIONS = (5, 8, 20, 40)
LEVEL: Final = "M"
REPAIRED: Final[tuple[tuple[int, Level], ...]] = ((1, "L"), (2, "M"), (5, "L"), (5, "H"), (8, "M"), (20, "Q"))
TRIALS: Final = 10
FAINT: Final = 0.05


def run() -> tuple[Table, Table]:
    """Times beside segno's for the same symbol, and the damage that recovery repairs."""
    return _times(), _repair()


def _times() -> Table:
    rows = [row for version in VERSIONS for row in _rows(version)]
    return Table(
        "symbol: times",
        ("version", "task", "ms", "of segno's encoding"),
        tuple(rows),
        (
            f"level {LEVEL}; medians of runs on this machine, the ratio is what compares",
            "damaged: r wrong codewords in every block; shaded: 5 more, all of them marked as doubtful",
        ),
    )


def _repair() -> Table:
    rows = [(f"{version}-{level}", *_most_repaired(version, level)) for version, level in REPAIRED]
    return Table(
        "symbol: wrong codewords repaired in every block",
        ("symbol", "codewords a block", "r", "plain", "with shades", "with shades, of r"),
        tuple(rows),
        (
            f"most at which {TRIALS} seeded trials all came back right; one to eight bits of each codeword",
            f"are wrong, known by a log-likelihood of {FAINT} against 1 elsewhere",
        ),
    )


def _most_repaired(version: int, level: Level) -> tuple[int, int, int, int, float]:
    symbol = encode(TEXT[:8], version=version, level=level)
    structure = symbol.blocks
    plain = 0
    while _all_repaired(symbol, plain + 1, with_shades=False):
        plain += 1
    shaded = plain
    while _all_repaired(symbol, shaded + 1, with_shades=True):
        shaded += 1
    length = structure.data[0] + structure.ec
    return length, structure.capacity, plain, shaded, shaded / structure.capacity


def _all_repaired(symbol: Symbol, count: int, with_shades: bool) -> bool:
    return all(_repairs(symbol, count, seed, with_shades) for seed in range(TRIALS))


def _repairs(symbol: Symbol, count: int, seed: int, with_shades: bool) -> bool:
    random = np.random.default_rng(seed)
    at = layout(symbol.version, symbol.level)
    chosen = np.concatenate([random.permutation(row)[:count] for group in at.groups for row in group])
    wrong = random.random((len(chosen), 8)) < 0.5
    wrong[np.arange(len(chosen)), random.integers(8, size=len(chosen))] = True
    modules = at.modules[chosen][wrong]
    observed = symbol.matrix.flipped(modules)
    shades = np.where(observed.dark, 1.0, -1.0)
    shades[modules[:, 0], modules[:, 1]] *= FAINT
    try:
        return recover(observed, log_likelihood=shades if with_shades else None).symbol == symbol
    except SymbolError:
        return False


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
