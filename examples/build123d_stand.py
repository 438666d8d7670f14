"""A code standing in a slotted foot: `PerforatedQR` inside a build123d model."""

import sys

from build123d import Align, Axis, Box, BuildPart, Locations, Mode, export_step, fillet

from perfqr_cad.frontends import PerforatedQR

OUT = sys.argv[1] if len(sys.argv) > 1 else "stand.step"

with BuildPart() as stand:
    Box(70, 24, 6, align=(Align.CENTER, Align.CENTER, Align.MAX))
    fillet(stand.edges().filter_by(Axis.Z), 4)
    with Locations((0, 0, -1)):
        PerforatedQR(
            "https://example.com/stand",
            60,
            2,
            rotation=(90, 0, 0),
            align=(Align.CENTER, Align.MIN, Align.CENTER),
            mode=Mode.ADD,
        )

export_step(stand.part, OUT)
print(f"{len(stand.part.solids())} solid, {stand.part.volume:.0f} mm³ -> {OUT}")
