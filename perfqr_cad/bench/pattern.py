"""Bridges by `optimal`, by the paper's Eq. (4), and by a plain spanning tree (λ = 0), on the same codes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import get_args

from perfqr_cad.capture import Art, read
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.pattern.cells.brightness import margin_left
from perfqr_cad.pattern.spec import Objective
from perfqr_cad.progress import tell
from perfqr_cad.symbol import Symbol, blocks, encode
from perfqr_cad.table import Table

CHECKOUT = Path(__file__).resolve().parents[2]
ART = CHECKOUT.parent / "shared" / "data" / "art"
VERSIONS = (1, 5, 8, 20, 40)
TEXT = "https://perfqr.example/"
LETTERS = "abcdefghijklmnopqrstuvwxyz0123456789-/"
FILL = 0.9  # of the capacity is text, so that the code is not mostly padding

COLUMNS = (
    "code",
    "objective",
    "islands",
    "bridges",
    "flipped",
    "lost",
    "L(Q)",
    "changed",
    "margin",
    "gap",
    "CPU s",
)


@dataclass(frozen=True, eq=False)
class CodeCase:
    """A symbol, with the art that shows it."""

    name: str
    symbol: Symbol
    art: Art | None


def run() -> Table:
    """One row per code and objective."""
    rows = tuple(_row(case, objective) for case in cases() for objective in get_args(Objective))
    return Table(
        "pattern: bridges by objective",
        COLUMNS,
        rows,
        (
            "flipped: modules read other than Q₀; lost: wrong codewords, those of the input included",
            "changed: area of the art that was changed, in modules; margin: least over the blocks of"
            " (capacity − expected wrong codewords under blur and noise)/capacity",
            "gap: between the price found and the proved bound, over the candidate routes",
        ),
    )


def cases() -> Iterator[CodeCase]:
    """Plain codes of several versions, then every artistic code at hand."""
    for version in VERSIONS:
        yield CodeCase(f"version {version}", plain_code(version), None)
    for path in sorted(ART.glob("*")) if ART.is_dir() else []:
        capture = read(path)
        yield CodeCase(path.name, capture.recovery.symbol, capture.art)


def plain_code(version: int) -> Symbol:
    """A level M code of a version, nearly full of text that looks random."""
    room = int(FILL * (blocks(version, "M").data_codewords - 3))
    noise = "".join(LETTERS[(k * k * 7 + k * 3) % 97 % len(LETTERS)] for k in range(room))
    return encode((TEXT + noise)[:room], version=version, level="M")


def _row(case: CodeCase, objective: Objective) -> tuple[object, ...]:
    tell(f"{case.name}: {objective}")
    began = process_time()
    pattern = build(case.symbol, PatternSpec(objective=objective), case.art)
    spent_s = process_time() - began
    gap = pattern.optimality.gap if pattern.optimality else None
    return (
        case.name,
        objective,
        pattern.islands_before,
        len(pattern.bridges),
        int((pattern.observed.dark != case.symbol.matrix.dark).sum()),
        sum(pattern.readability.errors),
        pattern.readability.total,
        pattern.changed_area_mm2 / pattern.module_mm**2,
        _margin(pattern),
        gap,
        spent_s,
    )


def _margin(pattern: Pattern) -> float:
    return margin_left(pattern.canvas.lattice, pattern.symbol)
