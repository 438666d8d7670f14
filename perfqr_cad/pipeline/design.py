"""A finished part and everything that was measured on the way."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from perfqr_cad.pipeline.request import Request

if TYPE_CHECKING:
    import build123d
    import cadquery

    from perfqr_cad.capture import Capture
    from perfqr_cad.export import FileRecord, Options
    from perfqr_cad.pattern import Pattern
    from perfqr_cad.pipeline.promises import Promise
    from perfqr_cad.pipeline.source import Source
    from perfqr_cad.scan import ScanReport
    from perfqr_cad.solid import Solid
    from perfqr_cad.structure import Reinforcement, SolidCheck, StressField
    from perfqr_cad.surface import Placement
    from perfqr_cad.symbol import Symbol


@dataclass(frozen=True)
class Design:
    """A finished part and everything that was measured on the way. Exporters read only this."""

    request: Request
    source: Source
    pattern: Pattern
    placement: Placement
    reinforcement: Reinforcement
    solid: Solid
    scan: ScanReport
    timings_s: dict[str, float] = field(default_factory=dict[str, float])
    verified: SolidCheck | None = None
    promises: tuple[Promise, ...] = ()
    files: tuple[FileRecord, ...] = ()

    @property
    def capture(self) -> Capture | None:
        """What the picture shows, if the code came from one."""
        return self.source.capture

    @property
    def symbol(self) -> Symbol:
        return self.source.symbol

    @property
    def stress(self) -> StressField:
        """The stress field of the finished part."""
        return self.reinforcement.after

    @property
    def mass_g(self) -> float:
        """Of the solid as it is, with its flared holes and all that it was carved into."""
        from perfqr_cad import structure
        from perfqr_cad.units import grams

        return grams(self.solid.volume_mm3, structure.material(self.request.material).density_kg_m3)

    @property
    def part(self) -> build123d.Part:
        """The part as a build123d object."""
        from perfqr_cad.solid.kernel.convert import to_build123d

        return to_build123d(self.solid)

    def workplane(self) -> cadquery.Workplane:
        """The part as a CadQuery object."""
        from perfqr_cad.solid.kernel.convert import to_cadquery

        return to_cadquery(self.solid)

    def certificate(self) -> dict[str, Any]:
        """Everything that was measured, as plain values; null where a link gave none."""
        from perfqr_cad.pipeline.certificate import certificate

        return certificate(self)

    def summary(self) -> str:
        """The certificate in a few lines for people."""
        from perfqr_cad.pipeline.certificate import summary

        return summary(self)

    def write(self, path: str | Path) -> FileRecord:
        """Write one file; its suffix is the format."""
        from perfqr_cad.export import write

        return write(self, path, self._options)

    def written(self, outputs: Sequence[str | Path]) -> Design:
        """Write files and folders; the design that knows of them."""
        from perfqr_cad.export import write_outputs

        begin = time.perf_counter()
        files = write_outputs(self, outputs, self._options)
        timings = self.timings_s | {"export": time.perf_counter() - begin}
        return replace(self, files=files, timings_s=timings)

    @property
    def _options(self) -> Options:
        """Variants of formats that were asked for."""
        from perfqr_cad.export import Options

        asked = self.request
        return Options(
            asked.dxf,  # pyright: ignore[reportArgumentType]  # checked there
            asked.dxf_bridges,
            asked.svg,  # pyright: ignore[reportArgumentType]
            asked.kerf_mm,
            asked.colour_change,
            asked.split_stl,
        )
