"""What a user can ask for, checked once."""

from __future__ import annotations

import contextlib
import math
from dataclasses import asdict, dataclass, fields
from typing import Any

from perfqr_cad.errors import DesignError


@dataclass(frozen=True)
class Request:
    """Every setting of a part. Lengths in mm, pressure and stress in MPa, angles in degrees.

    text, image      the payload, or a picture of an artistic code; exactly one of them
    mask             0 to 7; None: the one that needs the least joining
    size_mm          edge of the whole code with its quiet zone; None: the smallest the nozzle can make
    pressure_mpa     on the whole front; finger_n: force of a fingertip at the worst place; own_weight: the
                     part lies flat. They act together
    yield_mpa        None: the material's own
    fillet_mm        radius of re-entrant corners; None: half the nozzle
    colour, ground   of the part and of what lies behind it: a name or #rrggbb; None: white before black, or
                     black before white for the inverted tone
    frame_mm         width of a frame around the quiet zone; corner_radius_mm rounds its outer corners
    holes_mm         mounting holes in it: (x, y, diameter) each, from the centre of the code
    corner_hole_mm   diameter of four mounting holes in its corners; None: none
    caption          text on the frame, letters caption_height_mm high (None: half of
                     the frame, or less where lines need that) that stand caption_relief_mm out of the face;
                     below 0: engraved so deep. A new line begins another line
    caption_place    `bottom` or `top`: below or above the code
    font             of the caption: the name of an installed one, or a file; None: the one that comes along
    backing_mm       thickness of a plate backing_gap_mm behind, in the tone of the holes; None: none
    draft_deg        flare of the hole walls towards the back, behind a straight lip of lip_mm; None: plates
                     with through-holes flare as far as it helps the reader, all else is straight
    depth_mm         depth of blind pockets instead of through-holes; None: through
    verify_solid     whether the strength is checked once more in three dimensions
    scan_tilt_deg    tilt at which the part must still read; None: nothing is asked beyond the frontal view

    Raises `DesignError` for values that cannot be meant; each layer checks its own more closely.
    """

    text: str | None = None
    image: str | None = None
    name: str = "perforated-qr"
    level: str = "M"
    version: int | None = None
    mask: int | None = None
    size_mm: float | None = None
    thickness_mm: float = 1.6
    nozzle_mm: float = 0.4
    quiet_modules: int = 4
    style: str = "square"
    fillet_mm: float | None = None
    tone: str = "normal"
    colour: str | None = None
    ground: str | None = None
    frame_mm: float = 0.0
    corner_radius_mm: float = 0.0
    holes_mm: tuple[tuple[float, float, float], ...] = ()
    corner_hole_mm: float | None = None
    caption: str | None = None
    caption_height_mm: float | None = None
    caption_relief_mm: float = 0.4
    caption_place: str = "bottom"
    font: str | None = None
    backing_mm: float | None = None
    backing_gap_mm: float = 0.0
    finder: str = "recessed"
    objective: str = "optimal"
    contour: str = "smooth"
    draft_deg: float | None = None
    lip_mm: float | None = None
    depth_mm: float | None = None
    material: str = "PLA"
    pressure_mpa: float = 5e-6  # the paper's 5 Pa
    finger_n: float = 0.0
    own_weight: bool = False
    support: str = "clamped"
    yield_mpa: float | None = None
    method: str = "optimal"
    verify_solid: bool = False
    scan_tilt_deg: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if (self.text is None) == (self.image is None):
            raise DesignError("give either a text or a picture (--image FILE), not both and not neither")
        if self.text == "":
            raise DesignError("the text is empty: give at least 1 character")
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, float) and not math.isfinite(value):
                raise DesignError(f"{entry.name}={value} is not a finite number: give one")
        for name, low, high in _RANGES:
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise DesignError(f"{name}={value:g} is outside {low:g} to {high:g}: choose a value within")

    def as_dict(self) -> dict[str, Any]:
        """The settings as plain JSON values."""
        return asdict(self)


# Name, least, most. The ends are far beyond any printer, cutter or press; they catch slips of unit.
_RANGES: tuple[tuple[str, float, float], ...] = (
    ("version", 1, 40),
    ("mask", 0, 7),
    ("size_mm", 1.0, 10_000.0),
    ("thickness_mm", 0.05, 500.0),
    ("nozzle_mm", 0.01, 10.0),
    ("quiet_modules", 1, 20),
    ("fillet_mm", 0.0, 100.0),
    ("frame_mm", 0.0, 1000.0),
    ("corner_radius_mm", 0.0, 1000.0),
    ("corner_hole_mm", 0.01, 100.0),
    ("caption_height_mm", 0.1, 1000.0),
    ("caption_relief_mm", -100.0, 100.0),
    ("backing_mm", 0.05, 500.0),
    ("backing_gap_mm", 0.0, 500.0),
    ("draft_deg", 0.0, 60.0),
    ("lip_mm", 0.0, 500.0),
    ("depth_mm", 0.01, 500.0),
    ("pressure_mpa", 0.0, 1000.0),
    ("finger_n", 0.0, 1e5),
    ("yield_mpa", 1e-3, 1e5),
    ("scan_tilt_deg", 0.0, 60.0),
)


def read_holes(text: str) -> dict[str, Any]:
    """Mounting holes as people write them: `3` for four in the corners, `0,35,4; 0,-35,4` for x, y, diameter.

    The fields `holes_mm` and `corner_hole_mm` of a `Request`. Raises `DesignError` for anything else.
    """
    holes: list[tuple[float, ...]] = []
    corner: float | None = None
    for part in filter(None, (part.strip() for part in text.split(";"))):
        numbers: list[float] = []
        with contextlib.suppress(ValueError):
            numbers = [float(number) for number in part.split(",")]
        match numbers:
            case [diameter]:
                corner = diameter
            case [x, y, diameter]:
                holes.append((x, y, diameter))
            case _:
                raise DesignError(f"hole {part!r} is no diameter and no x,y,diameter: write 3 or 0,35,4 (mm)")
    return {"holes_mm": tuple(holes), "corner_hole_mm": corner}
