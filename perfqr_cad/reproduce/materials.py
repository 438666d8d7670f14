"""§6, third experiment: filaments from white to black on dark and light grounds, and the contrast limit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from perfqr_cad.progress import tell
from perfqr_cad.reproduce.exhibits import exhibit, handheld, rate, save
from perfqr_cad.scan import BLACK, WHITE, Look, View
from perfqr_cad.scan.camera.look import RGB
from perfqr_cad.scan.colours import FILAMENTS, contrast
from perfqr_cad.scan.decoding.decoders import CORE
from perfqr_cad.table import Table

GROUNDS: dict[str, RGB] = {"black": BLACK, "grey": (0.18, 0.18, 0.18), "white": WHITE}


def run(out: Path, views: int = 6) -> Table:
    """Success by filament and ground, sorted by contrast."""
    shown = exhibit("CADGraphics", out)
    rows: list[tuple[Any, ...]] = []
    for ground_name, ground in GROUNDS.items():
        for name, filament in FILAMENTS.items():
            tell(f"{name} on {ground_name}")
            look = Look(material=filament, ground=ground)
            rates = rate(shown.part, shown.payload, handheld(3.0, views, seed=5), look)
            rows.append((name, ground_name, contrast(filament, ground), *(rates[n] for n in (*CORE, "any"))))
    rows.sort(key=_contrast, reverse=True)
    pictures = [
        shown.part.photo_colour(View(10.0, 60.0, size_px=300), Look(material=f)) for f in FILAMENTS.values()
    ]
    save(out / "materials.png", pictures)
    lowest = [
        min((row[2] for row in rows if row[k] == 1.0), default=None) for k in range(3, 3 + len(CORE) + 1)
    ]
    limits = ", ".join(
        f"{name} {'none' if low is None else f'{low:.2f}'}"
        for name, low in zip((*CORE, "any"), lowest, strict=True)
    )
    return Table(
        "Materials: share of scans read",
        ("filament", "ground", "contrast", *CORE, "any"),
        tuple(rows),
        (
            f"lowest contrast at which every scan is read: {limits}",
            f"{views} scans each of the CADGraphics stand-in",
        ),
    )


def _contrast(row: tuple[Any, ...]) -> float:
    return row[2]
