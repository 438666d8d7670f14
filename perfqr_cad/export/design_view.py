"""What an exporter may read of a design."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.scan import ScanReport
    from perfqr_cad.solid import Solid
    from perfqr_cad.structure import Reinforcement, StressField
    from perfqr_cad.surface import Placement


class DesignView(Protocol):
    """The read-only face of `design.Design`. A link of the chain that has not run is None."""

    @property
    def pattern(self) -> Pattern: ...

    @property
    def placement(self) -> Placement: ...

    @property
    def solid(self) -> Solid: ...

    @property
    def stress(self) -> StressField | None: ...

    @property
    def reinforcement(self) -> Reinforcement | None: ...

    @property
    def scan(self) -> ScanReport | None: ...

    def certificate(self) -> dict[str, Any]: ...


def face(design: DesignView) -> Pattern:
    """The pattern as it lies on the upper face: mirrored where the part is read from below."""
    return design.pattern.mirrored() if design.placement.is_turned else design.pattern
