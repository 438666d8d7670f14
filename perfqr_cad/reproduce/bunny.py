"""The last column of Tables 1 and 2: the CADGraphics code carved into the Stanford Bunny, filmed from above.

Where the shared mesh is not at hand an egg of the same size takes its place.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from perfqr_cad.geometry import Triangles
from perfqr_cad.progress import tell
from perfqr_cad.reproduce.exhibits import captured_pattern, handheld, rate, save
from perfqr_cad.reproduce.stand_ins import SHARED, TABLE_1
from perfqr_cad.scan import FlatPrint, Look, Scene, View, place, printed
from perfqr_cad.scan.decoding.decoders import available
from perfqr_cad.table import Table

MESH = SHARED.parent / "meshes" / "bunny.off"
WALL_MM = 2.0
EXTENT_PER_CODE = 4.0  # the Bunny's longest edge over the code's: as large as its flank takes
TILTS_DEG = (0.0, 10.0, 20.0, 30.0)
VIEWS = ((0.0, 0.7), (25.0, 0.3))  # tilt and fill of the pictures


def run(out: Path, views: int = 8) -> Table:
    """Success by tilt on the curved mesh and on the flat print, for every engine present."""
    part, paper, payload = bunny(out)
    names = available()
    rows = []
    for tilt in TILTS_DEG:
        tell(f"bunny at {tilt:g}°")
        seen = handheld(tilt, views if tilt else 3, seed=6)
        for label, subject in (("bunny", part), ("print", paper)):
            rates = rate(subject, payload, seen, Look(), names=names)
            rows.append((tilt, label, *(rates[name] for name in (*names, "any"))))
    save(
        out / "bunny.png",
        [part.photo_colour(View(t, 40.0, size_px=500, fill=f)) for t, f in VIEWS],
    )
    made_of = "Stanford Bunny" if MESH.is_file() else "egg in place of the Bunny"
    return Table(
        "CADGraphics on the Bunny: share of scans read",
        ("tilt °", "what", *names, "any"),
        tuple(rows),
        (f"{made_of}, wall {WALL_MM:g} mm; the paper: four of five telephones, from the top only",),
    )


@lru_cache(maxsize=1)
def bunny(out: Path) -> tuple[Scene, FlatPrint, bytes]:
    """The carved mesh before the camera, the flat print of its code, and the payload."""
    from perfqr_cad.hosts.mesh import MeshTarget
    from perfqr_cad.profile import Walls

    tell("carve the Bunny")
    row = next(row for row in TABLE_1 if row.name == "CADGraphics")
    captured, pattern = captured_pattern(row, out)
    extent = EXTENT_PER_CODE * pattern.size_mm
    if MESH.is_file():
        target = MeshTarget(path=MESH, extent_mm=extent, hollow_mm=WALL_MM)
    else:
        target = MeshTarget.of(_egg(extent), hollow_mm=WALL_MM)
    placement = target.placement(pattern.size_mm)
    solid = target.solid(pattern, placement, Walls())
    art = captured.art
    paper = printed(art.dark, pattern.size_mm, quiet_modules=pattern.quiet_modules, scale=art.scale)
    scene = Scene(place(solid.triangles, placement, edge_mm=pattern.size_mm))
    return scene, paper, captured.recovery.payload.data


def _egg(extent_mm: float, rings: int = 60, around: int = 120) -> Triangles:
    """An ellipsoid of revolution, its longest edge as given."""
    polar = np.linspace(0, np.pi, rings + 1)[1:-1]
    turn = np.linspace(0, 2 * np.pi, around, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    body = [np.column_stack([0.4 * np.sin(p) * ring, np.full(around, 0.5 * np.cos(p))]) for p in polar]
    vertices = extent_mm * np.vstack([[[0, 0, 0.5]], *body, [[0, 0, -0.5]]])
    last = len(vertices) - 1
    step = np.arange(around)
    after = (step + 1) % around
    faces = [np.column_stack([np.zeros(around, int), 1 + step, 1 + after])]
    for k in range(rings - 2):
        a, b = 1 + k * around, 1 + (k + 1) * around
        faces += [
            np.column_stack([a + step, b + step, a + after]),
            np.column_stack([a + after, b + step, b + after]),
        ]
    end = 1 + (rings - 2) * around
    faces.append(np.column_stack([np.full(around, last), end + after, end + step]))
    return Triangles(vertices, np.vstack(faces))
