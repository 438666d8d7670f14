"""From a figure to a grade: limits of the standards, and what lies between them.

A figure at a limit has that whole grade; between two limits the grade runs straight, and beyond the last one
it is 0. (Editions before 2024 take the whole grade below. How the 2024 edition fills the gaps is in no public
text.)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

WHOLE = (4.0, 3.0, 2.0, 1.0)
# The grades that an overlay tries: all that are worth the name, best first.
LEVELS = tuple(round(4.0 - k / 10, 1) for k in range(31))
# The least grade of each letter (ISO/IEC 15416, rounding of means).
LETTERS = {"A": 3.5, "B": 2.5, "C": 1.5, "D": 0.5, "F": 0.0}

# Limits of the grades 4, 3, 2, 1. ISO/IEC 15415:
SYMBOL_CONTRAST = (0.70, 0.55, 0.40, 0.20)
MODULATION = (0.50, 0.40, 0.30, 0.20)
AXIAL = (0.06, 0.08, 0.10, 0.12)
GRID = (0.38, 0.50, 0.63, 0.75)
UNUSED_CORRECTION = (0.62, 0.50, 0.37, 0.25)
# ISO/IEC 18004, from memory: wrong modules of a corner, shares of wrong timing modules and alignment
# patterns, the mean of the segments, wrong bits of a copy of the format or version information.
CORNER = (0.0, 1.0, 2.0, 3.0)
TIMING = (0.0, 0.07, 0.11, 0.14)
ALIGNMENT = (0.0, 0.10, 0.20, 0.30)
SEGMENTS = (4.0, 3.5, 3.0, 2.5)
BITS = (0.0, 1.0, 2.0, 3.0)
# ISO/IEC 29158:
CELL_CONTRAST = (0.30, 0.25, 0.20, 0.15)
LEAST_REFLECTANCE = 0.05  # of the light modules: less cannot be graded


def grade_of(value: float, limits: tuple[float, ...]) -> float:
    """The grade, 0 to 4, of a figure.

    >>> [round(grade_of(x, SYMBOL_CONTRAST), 2) for x in (0.9, 0.55, 0.475, 0.19)]
    [4.0, 3.0, 2.5, 0.0]
    >>> round(grade_of(0.07, AXIAL), 2)
    3.5
    """
    rising = limits[0] > limits[-1]
    figures, grades = (limits[::-1], WHOLE[::-1]) if rising else (limits, WHOLE)
    if value < figures[0]:
        return 0.0 if rising else 4.0
    if value > figures[-1]:
        return 4.0 if rising else 0.0
    return float(np.interp(value, figures, grades))


def figure_for(grade: float, limits: tuple[float, ...]) -> float:
    """The figure that has a grade of 1 to 4: `grade_of` undone.

    >>> round(figure_for(2.5, MODULATION), 3)
    0.35
    """
    return float(np.interp(grade, WHOLE[::-1], limits[::-1]))


def overlaid(grade_with: Callable[[float], float]) -> float:
    """The best of all levels of modulation, where what falls short of a level counts as wrong (notional
    grades).

    grade_with   the grade with everything that has less than this modulation counted as wrong
    """
    best = 0.0
    for level in LEVELS:
        if level <= best:
            break
        best = max(best, min(level, grade_with(figure_for(level, MODULATION))))
    return best


def letter(grade: float) -> str:
    """The letter of a grade.

    >>> letter(3.5), letter(3.4), letter(0.4)
    ('A', 'B', 'F')
    """
    return next(name for name, least in LETTERS.items() if round(grade, 1) >= least)
