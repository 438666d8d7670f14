"""Text on the frame above or below the code, raised or engraved: where it stands, and whether it can."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
import shapely
from shapely.affinity import scale, translate
from shapely.geometry.base import BaseGeometry

from perfqr_cad.errors import DesignError
from perfqr_cad.geometry.outline import Region
from perfqr_cad.pattern.spec import GREATEST_SIZE_MM
from perfqr_cad.profile.lettering import Extent, drawn, extent, moved_region
from perfqr_cad.remedy import Remedy

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern, PatternSpec

Place = Literal["bottom", "top"]

FRAME_SHARE = 0.5  # of the frame's width that capital letters take, if nothing else is asked for
LEAST_FLOOR_MM = 0.4  # behind an engraved letter: two printed layers
LINE_SHARE = 0.5  # of the nozzle: slicers leave out, or close, what is narrower than half a line
LOST_SHARE = 0.2  # of a letter's ink that may come and go with such details
MEASURED_MM = 10.0  # height of capitals at which strokes are measured: shares of it, whatever the height
SLACK_MM = 1e-6  # rounding in lengths that were chosen to fit
HALVINGS = 30  # of a range in which a limit is sought
STEPS_PER_MM = 100  # lengths in remedies are multiples of 0.01 mm, on the side where they hold


@dataclass(frozen=True)
class Caption:
    """Text on the frame; a new line begins a line of its own.

    height_mm  of a capital letter
    relief_mm  how far letters stand out of the face; below 0: how deep they are engraved
    font       a family that is installed, or the path of a font file; None: a plain sans serif
    place      `bottom` or `top`: below or above the code

    Raises `DesignError` for values that cannot be meant, and for texts that cannot be drawn
    (`lettering.drawn`).
    """

    text: str
    height_mm: float
    relief_mm: float = 0.4
    font: str | None = None
    place: Place = "bottom"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.height_mm) and self.height_mm > 0):
            raise DesignError(f"letters of {self.height_mm:g} mm: give a height above 0")
        if not (math.isfinite(self.relief_mm) and self.relief_mm):
            raise DesignError(
                f"a relief of {self.relief_mm:g} mm: above 0 letters are raised, below engraved"
            )
        if self.place not in get_args(Place):
            raise DesignError(f"caption place {self.place!r} is not one of {', '.join(get_args(Place))}")
        self.letters()

    def letters(self) -> tuple[Region, ...]:
        """Outlines of the letters, mm, the lines centred about the origin."""
        return drawn(self.text, self.height_mm, self.font)

    @property
    def extent(self) -> Extent:
        """How much room the letters take, in heights of a capital."""
        return extent(self.text, self.font)

    def placed(self, pattern: Pattern, thickness_mm: float) -> tuple[Region, ...]:
        """The letters in the middle of their strip of the frame.

        Raises `DesignError` where they do not fit, or are too fine for the nozzle.
        """
        self.require_fit(pattern.spec)
        _require_floor(self, thickness_mm)
        strip = _Strip(pattern.spec, pattern.size_mm, self.place)
        _require_room(self, strip)
        up = strip.middle_mm - self.height_mm * self.extent.middle
        return tuple(moved_region(letter, 1.0, 0.0, up) for letter in self.letters())

    def require_fit(self, spec: PatternSpec) -> None:
        """What is known before the code is drawn: raises `DesignError` where the lines are too high for the
        frame, or too fine for the nozzle."""
        _require_frame(self, spec)
        _require_printable(self, spec)

    def is_printable(self, height_mm: float, nozzle_mm: float) -> bool:
        """Whether, so high, letters keep their strokes and gaps when those under half a line go."""
        if height_mm <= 0:
            return False
        narrowest_mm = LINE_SHARE * nozzle_mm * MEASURED_MM / height_mm
        return _lost(drawn(self.text, MEASURED_MM, self.font), narrowest_mm) <= LOST_SHARE


def fitting_height_mm(text: str, font: str | None, frame_mm: float, web_mm: float) -> float:
    """Height of capitals when none is asked for: half of the frame, less where lines need that to fit."""
    height_mm = FRAME_SHARE * frame_mm
    if frame_mm <= web_mm:
        return height_mm  # for which there is no room, as will be said
    return min(height_mm, (frame_mm - web_mm) / extent(text, font).height)


@dataclass(frozen=True)
class _Strip:
    """The part of a frame that a caption stands in: on one side of a code of some size."""

    spec: PatternSpec
    size_mm: float
    place: Place

    @property
    def middle_mm(self) -> float:
        """Where it is, from the centre of the code upwards."""
        away = (self.size_mm + self.spec.surround.frame_mm - self.spec.web_mm) / 2
        return away if self.place == "top" else -away

    def gap_mm(self, ink: BaseGeometry) -> float:
        """What ink in its middle leaves to the outer edge and to mounting holes."""
        placed = translate(ink, 0.0, self.middle_mm)
        rim = shapely.Polygon(self.spec.surround.outline(self.size_mm).flatten())
        gaps = [rim.exterior.distance(placed) if rim.covers(placed) else 0.0]
        for hole in self.spec.surround.all_holes(self.size_mm):
            gaps.append(placed.distance(shapely.Point(hole.x_mm, hole.y_mm)) - hole.diameter_mm / 2)
        return max(min(gaps), 0.0)

    def has_room(self, ink: BaseGeometry) -> bool:
        """Whether half a web is left, beside the web below the letters."""
        return self.gap_mm(ink) >= self.spec.web_mm / 2 - SLACK_MM


def _require_floor(caption: Caption, thickness_mm: float) -> None:
    """Behind engraved letters there is something left."""
    depth_mm = -caption.relief_mm
    if depth_mm <= 0 or thickness_mm - depth_mm >= LEAST_FLOOR_MM - SLACK_MM:
        return
    deepest_mm = _down(thickness_mm - LEAST_FLOOR_MM)
    less = [Remedy(caption_relief_mm=-deepest_mm)] if deepest_mm > 0 else []
    raise DesignError(
        f"letters engraved by {depth_mm:g} mm leave less than {LEAST_FLOOR_MM:g} mm of a wall of "
        f"{thickness_mm:g} mm",
        *less,
        Remedy(thickness_mm=_up(depth_mm + LEAST_FLOOR_MM)),
    )


def _require_frame(caption: Caption, spec: PatternSpec) -> None:
    """The frame is as wide as the lines are high, and a web."""
    frame_mm = spec.surround.frame_mm
    high_mm = caption.height_mm * caption.extent.height
    if high_mm + spec.web_mm <= frame_mm + SLACK_MM:
        return
    smaller_mm = _down((frame_mm - spec.web_mm) / caption.extent.height)
    printable = caption.is_printable(smaller_mm, spec.nozzle_mm)
    raise DesignError(
        f"letters {high_mm:.3g} mm high do not fit a frame of {frame_mm:g} mm with {spec.web_mm:g} mm "
        f"beside them",
        Remedy(frame_mm=_up(high_mm + spec.web_mm)),
        *([Remedy(caption_height_mm=smaller_mm)] if printable else []),
    )


def _require_printable(caption: Caption, spec: PatternSpec) -> None:
    """The nozzle can lay the strokes, and leave the gaps."""
    if caption.is_printable(caption.height_mm, spec.nozzle_mm):
        return
    height_mm = _up(_limit(lambda h: caption.is_printable(h, spec.nozzle_mm), spec.nozzle_mm * 1e3, 0.0))
    frame_mm = caption.extent.height * height_mm + spec.web_mm
    wider = {"frame_mm": _up(frame_mm)} if frame_mm > spec.surround.frame_mm else {}
    raise DesignError(
        f"letters {caption.height_mm:.3g} mm high have strokes or gaps narrower than half a nozzle line "
        f"({LINE_SHARE * spec.nozzle_mm:g} mm)",
        Remedy(caption_height_mm=height_mm, **wider),
        "a finer nozzle",
    )


def _require_room(caption: Caption, strip: _Strip) -> None:
    """Letters keep away from the part's edge and from mounting holes."""
    ink = _ink(caption)
    if strip.has_room(ink):
        return
    raise DesignError(
        f"a caption {caption.height_mm * caption.extent.width:.3g} mm wide comes within "
        f"{strip.gap_mm(ink):.3g} mm of the edge or a mounting hole (limit {strip.spec.web_mm / 2:g} mm)",
        *_more_room(caption, strip, ink),
        "a shorter text",
    )


def _more_room(caption: Caption, strip: _Strip, ink: BaseGeometry) -> Iterator[Remedy]:
    """What would let a caption stand clear; each has been tried."""

    def scaled(share: float) -> bool:
        return strip.has_room(scale(ink, share, share, origin=(0.0, 0.0)))

    def sized(size_mm: float) -> bool:
        return replace(strip, size_mm=size_mm).has_room(ink)

    height_mm = _down(caption.height_mm * _limit(scaled, 0.0, 1.0))
    if caption.is_printable(height_mm, strip.spec.nozzle_mm):
        yield Remedy(caption_height_mm=height_mm)
    other: Place = "bottom" if strip.place == "top" else "top"
    if replace(strip, place=other).has_room(ink):
        yield Remedy(caption_place=other)
    # Holes that are placed by hand do not move out with the edge.
    if not strip.spec.surround.holes and sized(GREATEST_SIZE_MM):
        yield Remedy(size_mm=_up(_limit(sized, GREATEST_SIZE_MM, strip.size_mm)))


def _ink(caption: Caption) -> BaseGeometry:
    """The convex hull of the letters about their middle."""
    corners = np.vstack([letter.outer.flatten() for letter in caption.letters()])
    return shapely.MultiPoint(corners - (0.0, caption.height_mm * caption.extent.middle)).convex_hull


def _lost(letters: Sequence[Region], narrowest_mm: float) -> float:
    """The greatest share of a letter's ink that goes with strokes under a width, or comes with such gaps."""
    shares: list[float] = []
    for letter in letters:
        ink, step = letter.polygon(), narrowest_mm / 2
        opened, closed = ink.buffer(-step).buffer(step).area, ink.buffer(step).buffer(-step).area
        shares.append(max(ink.area - opened, closed - ink.area) / ink.area)
    return max(shares)


def _limit(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """The last value at which something holds, on the way from where it does to where it does not."""
    for _ in range(HALVINGS):
        middle = (good + bad) / 2
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def _up(length_mm: float) -> float:
    return math.ceil(length_mm * STEPS_PER_MM - SLACK_MM) / STEPS_PER_MM


def _down(length_mm: float) -> float:
    return math.floor(length_mm * STEPS_PER_MM + SLACK_MM) / STEPS_PER_MM
