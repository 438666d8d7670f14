"""Writes the golden outlines: `python tests/golden/export_files.py`, after a change of format that is meant.

The part is a 12 × 8 × 1.5 mm plate with every kind of segment, a letter and a backing; the files are short
enough to be read by eye.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

from perfqr_cad import export
from perfqr_cad.geometry import Arc, Bezier, Circle, Line, Loop, Region
from perfqr_cad.pattern import Bridge, Hole, PatternSpec, Surround

GOLDEN = Path(__file__).with_name("export")
NAMES = ("part.svg", "cut.svg", "part.scad")
THICKNESS_MM, RELIEF_MM = 1.5, 0.4


def part() -> SimpleNamespace:
    """The plate as exporters see it."""
    outer = Loop(
        (
            Line((-6, -4), (6, -4)),
            Line((6, -4), (6, 3)),
            Arc((6, 3), (5, 4), (5, 3), True),
            Line((5, 4), (-6, 4)),
            Line((-6, 4), (-6, -4)),
        )
    )
    drop = Loop((Bezier((2, 0), (2, -1.5), (4, -1.5), (4, 0)), Line((4, 0), (2, 0)))).oriented(ccw=False)
    region = Region(outer, (Loop((Circle((-3, 1), 1.25, False),)), drop))
    bridge = Bridge((-3, -0.25), (-3, 2.25), 0.8, "structural", 1.0)
    spec = PatternSpec(surround=Surround(holes=(Hole(-3, 1, 2.5),)))
    backing = SimpleNamespace(
        name="backing", colour=(0.05, 0.05, 0.06), bbox_mm=((-6.0, -4.0, -1.2), (6.0, 4.0, -0.2))
    )
    ring = Region(
        Loop.from_points([(-1, -3.5), (1, -3.5), (1, -2), (-1, -2)]),
        (Loop.from_points([(-0.5, -3), (-0.5, -2.5), (0.5, -2.5), (0.5, -3)]),),
    )
    return SimpleNamespace(
        pattern=SimpleNamespace(region=region, bridges=(bridge,), spec=spec, size_mm=8.0),
        placement=SimpleNamespace(is_flat=True, is_turned=False, thickness_mm=THICKNESS_MM),
        solid=SimpleNamespace(
            name="golden plate",
            colour=(0.92, 0.92, 0.9),
            volume_mm3=region.area * THICKNESS_MM + ring.area * RELIEF_MM,
            letters=(ring,),
            relief_mm=RELIEF_MM,
            is_carved=False,
            extras=(backing,),
        ),
    )


def write(folder: Path) -> None:
    """Write every golden file into a folder."""
    for name in NAMES:
        options = export.Options(svg="cut" if name == "cut.svg" else "filled")
        export.write(part(), folder / name, options)


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    write(GOLDEN)
