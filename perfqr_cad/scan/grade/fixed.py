"""Grades of what is drawn in every symbol: finders, timing, alignment; format and version information.

Everything is graded under an overlay of modulation: at each level, modules with less than it count as wrong.
ISO/IEC 18004, annex on print quality; the segments and their limits are from memory, not from public text.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.grade.scale import ALIGNMENT, BITS, CORNER, SEGMENTS, TIMING, grade_of, overlaid
from perfqr_cad.symbol import Role, Symbol, layout

Floats = NDArray[np.float64]
FINDER_AND_SEPARATOR = 8  # modules


@dataclass(frozen=True)
class FixedPatterns:
    """Grades of the segments by name, and their modules on the wrong side of the threshold: A1 to A3 are the
    corners with their quiet zone, B1 and B2 timing, C alignment."""

    segments: dict[str, float]
    wrong: dict[str, int]

    @property
    def grade(self) -> float:
        """The least of the segments, and of the grade of their mean."""
        grades = list(self.segments.values())
        return min(*grades, grade_of(round(float(np.mean(grades)), 9), SEGMENTS))


def fixed_patterns(margin: Floats, symbol: Symbol, quiet: int) -> FixedPatterns:
    """Fixed pattern damage from the margins (m, m) of all modules, `quiet` of them around the symbol.

    A margin is the modulation of a module, negative on the wrong side of the threshold.
    """
    n, reach = symbol.size, FINDER_AND_SEPARATOR
    own = margin[quiet : quiet + n, quiet : quiet + n]
    near, far = slice(0, quiet + reach), slice(quiet + n - reach, None)
    corners = {"A1": margin[near, near], "A2": margin[near, far], "A3": margin[far, near]}
    lines = {"B1": own[6, reach : n - reach], "B2": own[reach : n - reach, 6]}
    segments = {
        name: overlaid(lambda least, part=part: grade_of(int(np.count_nonzero(part < least)), CORNER))
        for name, part in corners.items()
    }
    segments |= {
        name: overlaid(lambda least, part=part: grade_of(float(np.mean(part < least)), TIMING))
        for name, part in lines.items()
    }
    patterns = alignment_modules(symbol)
    if len(patterns):
        weakest = own[patterns[..., 0], patterns[..., 1]].min(axis=(1, 2))
        segments["C"] = overlaid(lambda least: grade_of(float(np.mean(weakest < least)), ALIGNMENT))
    wrong = {name: int(np.count_nonzero(part < 0)) for name, part in (corners | lines).items()}
    if len(patterns):
        wrong["C"] = int(np.count_nonzero(own[patterns[..., 0], patterns[..., 1]] < 0))
    return FixedPatterns(segments, wrong)


def information(margin: Floats, symbol: Symbol) -> float:
    """The grade of format and version information from the margins (n, n): the worse of the two, each the
    mean of its two copies."""
    at = layout(symbol.version, symbol.level)
    grades: list[float] = []
    for places in (at.format_modules, at.version_modules):
        copies = [margin[copy[:, 0], copy[:, 1]] for copy in places if len(copy)]
        found = [
            overlaid(lambda least, bits=bits: grade_of(int(np.count_nonzero(bits < least)), BITS))
            for bits in copies
        ]
        grades += [float(np.mean(found))] if found else []
    return min(grades)


def alignment_modules(symbol: Symbol) -> NDArray[np.intp]:
    """Rows and columns (k, 5, 5, 2) of the modules of every alignment pattern.

    Those on a timing line share modules with it.
    """
    roles = layout(symbol.version, symbol.level).roles
    first = [
        (row, column)
        for row, column in np.argwhere(roles == Role.ALIGNMENT)
        if not (row and roles[row - 1, column] == Role.ALIGNMENT)
        and not (column and roles[row, column - 1] == Role.ALIGNMENT)
    ]
    inside = np.argwhere(np.ones((5, 5))).reshape(5, 5, 2)
    return np.array([corner + inside for corner in np.array(first, np.intp).reshape(-1, 2)], np.intp).reshape(
        -1, 5, 5, 2
    )
