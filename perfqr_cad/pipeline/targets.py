"""What a code is carved into, and what lies around and behind it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline.request import Request
from perfqr_cad.remedy import Remedy

if TYPE_CHECKING:
    from perfqr_cad.geometry import Triangles
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.pipeline.resolve import Terms
    from perfqr_cad.profile import Backing, Caption, Walls
    from perfqr_cad.solid import Solid
    from perfqr_cad.surface import Placement

# Settings of what lies around and behind a code, which a part of one's own has already. Its thickness is no
# such: templates that make a part have one of their own.
OF_SHEETS = ("frame_mm", "corner_radius_mm", "hole_mm", "caption", "backing_mm")


class Target(Protocol):
    """What the code is carved into."""

    @property
    def behind(self) -> Triangles | None:
        """A dark body that the finished part sits on and that is seen through its holes, or None."""
        ...

    def placement(self, size_mm: float, depth_mm: float | None = None) -> Placement:
        """Where a code of this edge (with quiet zone and frame) lies, with pockets so deep or through-holes.
        `DesignError` when it does not fit."""
        ...

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        """The finished part."""
        ...


@dataclass(frozen=True)
class Sheet:
    """A wall of even thickness, bent like the surface it is given: the target unless another is named.

    caption, backing   what is written on its frame, and the plate behind it; a `Request` that asks for them
                       overrides these
    """

    surface: Placement
    caption: Caption | None = None
    backing: Backing | None = None

    @property
    def behind(self) -> None:
        """Nothing: the ground is seen through the holes."""

    def placement(self, size_mm: float, depth_mm: float | None = None) -> Placement:
        """The surface, once its distortion is within the limit."""
        self.surface.check(size_mm)
        return self.surface

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        """The code's own piece of that wall, with its caption and the plate behind it."""
        from perfqr_cad.solid import back, build

        part = build(pattern, placement, walls, caption=self.caption)
        return (
            part if self.backing is None else replace(part, extras=(back(pattern, placement, self.backing),))
        )


@dataclass(frozen=True)
class TurnedSheet:
    """A flat sheet turned over: its face at the top shows the code mirrored, and it is read from below."""

    sheet: Sheet

    @property
    def behind(self) -> None:
        """Nothing: the ground is seen through the holes."""

    def placement(self, size_mm: float, depth_mm: float | None = None) -> Placement:
        """The reader's side, the lower one. Raises `DesignError` for what cannot be read from there."""
        from perfqr_cad.surface import TurnedPlane

        if depth_mm is not None:
            raise DesignError(
                f"pockets of {depth_mm:g} mm are not seen from behind",
                Remedy(mirror=None),
                Remedy(depth_mm=None),
            )
        return TurnedPlane(self.sheet.placement(size_mm).thickness_mm)

    def solid(self, pattern: Pattern, placement: Placement, walls: Walls) -> Solid:
        """The sheet's own piece, turned over."""
        from perfqr_cad.solid.kernel.turn import turned

        made = self.sheet.solid(pattern, self.sheet.surface, walls)
        return turned(made, placement.thickness_mm)


@dataclass(frozen=True)
class Site:
    """A target and the place in it where the code lies."""

    target: Target
    placement: Placement

    def solid(self, pattern: Pattern, terms: Terms) -> Solid:
        """The finished part in its colour."""
        return replace(self.target.solid(pattern, self.placement, terms.walls), colour=terms.colour)

    def behind(self, solid: Solid) -> Triangles | None:
        """The body that is seen through the holes. Behind a flat part a backing is but a near ground."""
        flat = self.placement.is_flat or not solid.extras
        return self.target.behind if flat else solid.extras[0].triangles


def locate(target: Target | None, terms: Terms, extent_mm: float) -> Site:
    """The place of a code of this extent in a target; without one, in a plate of the thickness asked for.

    Raises `DesignError` where the code does not fit, or its walls do not fit the material there.
    """
    from perfqr_cad.surface import Plane

    furnished = _furnished(target or Sheet(Plane(terms.request.thickness_mm)), terms)
    if terms.request.mirror:
        if not (isinstance(furnished, Sheet) and furnished.surface.is_flat):
            raise DesignError(
                "a code in a curved wall or a part of your own is read from its front", Remedy(mirror=None)
            )
        furnished = TurnedSheet(furnished)
    placement = furnished.placement(extent_mm, terms.walls.depth_mm)
    terms.walls.require_fit(placement.thickness_mm)
    return Site(furnished, placement)


def _furnished(target: Target, terms: Terms) -> Target:
    """The target with the caption and the backing that are asked for, which only a sheet can have."""
    if isinstance(target, Sheet):
        return replace(
            target, caption=terms.caption or target.caption, backing=terms.backing or target.backing
        )
    plain, request = Request(text="-"), terms.request
    if asked := [name for name in OF_SHEETS if getattr(request, name) != getattr(plain, name)]:
        raise DesignError(
            f"{', '.join(asked)}: a code in a part of your own has the part around it",
            Remedy(**dict.fromkeys(asked)),
        )
    return target
