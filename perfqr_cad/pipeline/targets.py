"""What a code is carved into, and what lies around and behind it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

from perfqr_cad.errors import DesignError
from perfqr_cad.pipeline import resolve as terms

if TYPE_CHECKING:
    from perfqr_cad.geometry import Triangles
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.pipeline.request import Request
    from perfqr_cad.profile import Backing, Caption, Walls
    from perfqr_cad.solid import Solid
    from perfqr_cad.surface import Placement


class Target(Protocol):
    """What the code is carved into."""

    @property
    def behind(self) -> Triangles | None:
        """A dark body that the finished part sits on and that is seen through its holes, or None."""
        ...

    def placement(self, size_mm: float) -> Placement:
        """Where a code of this edge (with quiet zone and frame) lies. `DesignError` when it does not fit."""
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

    def placement(self, size_mm: float) -> Placement:
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


def plate(request: Request) -> Sheet:
    """The flat plate that a request means when no target is named."""
    from perfqr_cad.surface import Plane

    return Sheet(Plane(request.thickness_mm))


def dressed(target: Target, request: Request) -> Target:
    """The target with the caption and the backing that are asked for, which only a sheet can have."""
    if isinstance(target, Sheet):
        caption, backing = terms.caption(request), terms.backing(request)
        return replace(target, caption=caption or target.caption, backing=backing or target.backing)
    wishes = ("frame_mm", "corner_radius_mm", "holes_mm", "corner_hole_mm", "caption", "backing_mm")
    if asked := [name for name in wishes if getattr(request, name)]:
        raise DesignError(
            f"{', '.join(asked)}: a code in a part of your own has the part around it: leave these out"
        )
    return target


def behind(target: Target, solid: Solid, placement: Placement) -> Triangles | None:
    """The body that is seen through the holes. Behind a flat part a backing is but a near ground."""
    return target.behind if placement.is_flat or not solid.extras else solid.extras[0].triangles
