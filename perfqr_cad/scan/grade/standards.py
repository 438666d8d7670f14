"""Parameters of ISO/IEC 15415 and ISO/IEC 29158 on what a verifier sees, and the grade they add up to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.scan.grade import scale
from perfqr_cad.scan.grade.fixed import FixedPatterns, alignment_modules, fixed_patterns, information
from perfqr_cad.scan.grade.scale import grade_of, letter, overlaid
from perfqr_cad.scan.grade.verifier import Sampled, centroid
from perfqr_cad.symbol import QUIET_MODULES, Symbol, layout

Floats = NDArray[np.float64]
APERTURE = 0.8  # of a module, where the application names none
APERTURES = (0.5, 0.8)  # those of 29158, the better of which counts
MIL_MM = 0.0254  # apertures are written in thousandths of an inch
WAVELENGTH_NM = 660
FINDER_CENTRE, FINDER_HALF = 3, 1.5  # its dark core: module of the middle, half the edge
ALIGNMENT_HALF = 0.5


@dataclass(frozen=True)
class Grade:
    """The grade of a symbol by one standard, before one ground.

    edition      the standard
    aperture     diameter in modules; module_mm their edge
    figures      what was measured, by parameter
    grades       0 to 4, by parameter; the least is the symbol's
    fixed        the segments of fixed pattern damage
    """

    edition: str
    aperture: float
    module_mm: float
    figures: Mapping[str, float]
    grades: Mapping[str, float]
    fixed: FixedPatterns

    @property
    def overall(self) -> float:
        """The symbol's grade, in steps of 0.1."""
        return round(min(self.grades.values()), 1)

    @property
    def letter(self) -> str:
        """The same as a letter."""
        return letter(self.overall)

    @property
    def limiting(self) -> str:
        """The parameter that the grade hangs on."""
        return min(self.grades, key=lambda name: self.grades[name])

    @property
    def written(self) -> str:
        """Grade, aperture in thousandths of an inch and wavelength, as the standards write it."""
        mils = round(self.aperture * self.module_mm / MIL_MM)
        if "29158" in self.edition:
            return f"DPM{self.overall:.1f}/{mils:02d}/{WAVELENGTH_NM}/45Q"
        return f"{self.overall:.1f}/{mils:02d}/{WAVELENGTH_NM}"

    def as_dict(self) -> dict[str, Any]:
        """For the certificate."""
        return {
            "written": self.written,
            "edition": self.edition,
            "status": "simulated, not verified",
            "grade": self.overall,
            "letter": self.letter,
            "limited_by": self.limiting,
            "aperture_modules": self.aperture,
            "parameters": {
                name: {
                    "value": None if name not in self.figures else round(float(self.figures[name]), 4),
                    "grade": round(grade, 1),
                }
                for name, grade in self.grades.items()
            },
            "fixed_patterns": {
                name: {"grade": round(grade, 1), "wrong_modules": self.fixed.wrong[name]}
                for name, grade in self.fixed.segments.items()
            },
        }


def print_quality(seen: Sampled, aperture: float = APERTURE) -> Grade:
    """ISO/IEC 15415: contrast of the whole symbol, threshold half-way between its extremes."""
    least, greatest = seen.extremes(aperture)
    contrast, threshold = greatest - least, (greatest + least) / 2
    side = np.where(seen.light, 1.0, -1.0)
    margin = side * 2 * (seen.reflectances(aperture) - threshold) / max(contrast, 1e-9)
    figures = {"symbol contrast": contrast, "reflectance at most": greatest, "reflectance at least": least}
    own = {"symbol contrast": grade_of(contrast, scale.SYMBOL_CONTRAST)}
    own["modulation"] = modulation_grade(np.abs(margin), margin, seen)
    own["reflectance margin"] = modulation_grade(np.maximum(margin, 0.0), margin, seen)
    return _graded("ISO/IEC 15415:2024", aperture, seen, margin, threshold, figures, own)


def dpm(seen: Sampled) -> Grade:
    """ISO/IEC 29158 for marks on parts: contrast and threshold of the modules' own centres."""
    found = [_dpm(seen, aperture) for aperture in APERTURES]
    return max(found, key=lambda grade: grade.overall)


def _dpm(seen: Sampled, aperture: float) -> Grade:
    values = seen.reflectances(aperture)
    threshold = two_means_threshold(values)
    bright, dim = values > threshold, values <= threshold
    light, dark = (float(values[some].mean()) if some.any() else threshold for some in (bright, dim))
    contrast = (light - dark) / max(light, 1e-9)
    off = np.where(
        bright,
        (values - threshold) / max(light - threshold, 1e-9),
        (threshold - values) / max(threshold - dark, 1e-9),
    )
    margin = np.where(bright == seen.light, off, -off)
    figures = {"cell contrast": contrast, "least reflectance": light}
    own = {
        "cell contrast": grade_of(contrast, scale.CELL_CONTRAST),
        "least reflectance": 4.0 if light >= scale.LEAST_REFLECTANCE else 0.0,
        "cell modulation": modulation_grade(np.maximum(margin, 0.0), margin, seen),
    }
    return _graded("ISO/IEC 29158:2020", aperture, seen, margin, threshold, figures, own)


def _graded(
    edition: str,
    aperture: float,
    seen: Sampled,
    margin: Floats,
    threshold: float,
    figures: dict[str, float],
    grades: dict[str, float],
) -> Grade:
    """The parameters that the standards share, beside their own."""
    symbol, inside = seen.symbol, np.s_[seen.quiet : len(margin) - seen.quiet]
    own = margin[inside, inside]
    fixed = fixed_patterns(margin, symbol, seen.quiet)
    axial, grid = uniformity(seen, seen.through(aperture) < threshold)
    unused = unused_correction(own < 0, symbol)
    around = np.delete(margin.ravel(), _flat_index(len(margin), seen.quiet))
    quiet_zone = seen.quiet >= QUIET_MODULES and bool(np.all(around >= 0))
    shared = {
        "fixed pattern damage": fixed.grade,
        "format and version": information(own, symbol),
        "axial non-uniformity": grade_of(axial, scale.AXIAL),
        "grid non-uniformity": grade_of(grid, scale.GRID),
        "unused error correction": grade_of(unused, scale.UNUSED_CORRECTION),
        "quiet zone": 4.0 if quiet_zone else 0.0,
    }
    measured = {
        "axial non-uniformity": axial,
        "grid non-uniformity": grid,
        "unused error correction": unused,
        "quiet zone": float(seen.quiet),
    }
    return Grade(edition, aperture, seen.module_mm, figures | measured, grades | shared, fixed)


def _flat_index(count: int, quiet: int) -> NDArray[np.intp]:
    """Flat indices of the symbol's own modules in an array with its quiet zone."""
    inside = np.zeros((count, count), np.bool_)
    inside[quiet : count - quiet, quiet : count - quiet] = True
    return np.flatnonzero(inside)


def modulation_grade(modulation: Floats, margin: Floats, seen: Sampled) -> float:
    """The grade of the codewords' modulation (m, m): at each level, codewords that fall short count as wrong
    beside those that are."""
    inside = np.s_[seen.quiet : len(margin) - seen.quiet]
    worst, wrong = modulation[inside, inside], margin[inside, inside] < 0

    def with_least(least: float) -> float:
        return grade_of(unused_correction(wrong | (worst < least), seen.symbol), scale.UNUSED_CORRECTION)

    return overlaid(with_least)


def unused_correction(wrong: NDArray[np.bool_], symbol: Symbol) -> float:
    """1 − 2t / (d − p) of the worst block, 0 to 1, with these modules (n, n) wrong."""
    at = layout(symbol.version, symbol.level)
    errors = wrong[at.modules[..., 0], at.modules[..., 1]].any(axis=1)
    most = int(np.bincount(at.block_of_codeword[errors], minlength=at.blocks.count).max())
    return max(0.0, 1.0 - 2 * most / (at.blocks.ec - at.blocks.protection))


def uniformity(seen: Sampled, dark: NDArray[np.bool_]) -> tuple[float, float]:
    """Axial and grid non-uniformity of what is seen, from the binary picture (H, W).

    The axes are those between the centres of the finders; grid points are where alignment patterns are seen,
    and where modules are if the surface bends them, against the even grid of the three finders.
    """
    n = seen.symbol.size
    far = n - 1 - FINDER_CENTRE
    corner, right, below = (
        centroid(seen, dark, row, column, FINDER_HALF)
        for row, column in ((FINDER_CENTRE, FINDER_CENTRE), (FINDER_CENTRE, far), (far, FINDER_CENTRE))
    )
    across, down = (right - corner) / (n - 7), (below - corner) / (n - 7)
    x, y = float(np.linalg.norm(across)), float(np.linalg.norm(down))
    axial = abs(x - y) / ((x + y) / 2)
    rows, columns = np.mgrid[0:n, 0:n] - FINDER_CENTRE
    even = corner + columns[..., None] * across + rows[..., None] * down
    inside = np.s_[seen.quiet : n + seen.quiet]
    shifts = [np.linalg.norm(seen.centres_px[inside, inside] - even, axis=-1).max()]
    for row, column in alignment_modules(seen.symbol)[:, 2, 2]:
        at = centroid(seen, dark, int(row), int(column), ALIGNMENT_HALF)
        shifts.append(np.linalg.norm(at - even[row, column]))
    return axial, float(max(shifts)) / ((x + y) / 2)


def two_means_threshold(values: Floats) -> float:
    """T2 of 29158: where the variances of what lies below and above add up to the least (from memory);
    half-way between the two values it lies between."""
    ordered = np.sort(values.ravel())
    count = np.arange(1, len(ordered))
    first, second = np.cumsum(ordered)[:-1], np.cumsum(ordered**2)[:-1]
    low = second / count - (first / count) ** 2
    rest = len(ordered) - count
    high = (np.sum(ordered**2) - second) / rest - ((ordered.sum() - first) / rest) ** 2
    k = int(np.argmin(low + high))
    return float(ordered[k] + ordered[k + 1]) / 2
