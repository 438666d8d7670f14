"""Table 2: which decoders read the five parts and the Bunny from straight above, before a black ground.

The paper tried five telephones with their readers; these are the engines that such readers are made of.
"""

from __future__ import annotations

from pathlib import Path

from perfqr_cad.reproduce.bunny import bunny
from perfqr_cad.reproduce.exhibits import exhibits, handheld, rate, save
from perfqr_cad.scan import Look, View
from perfqr_cad.scan.decoding.decoders import available
from perfqr_cad.scan.schedule import PATIENCE
from perfqr_cad.table import Table


def run(out: Path) -> Table:
    """Decoders x codes; a code whose flat print is not read either is marked."""
    names = available()
    shown = [(e.name, e.part, e.print, e.payload) for e in exhibits(out)]
    shown.append(("CADGraphics (bunny)", *bunny(out)))
    views = handheld(0.0, PATIENCE, seed=2)
    columns: list[dict[str, str]] = []
    for _, part, paper, payload in shown:
        mine = rate(part, payload, views, Look(), names=names)
        flat = rate(paper, payload, views, Look(), names=names)
        columns.append({name: _mark(mine[name], flat[name]) for name in names})
    save(out / "table2.png", [part.photo(View(size_px=400)) for _, part, _, _ in shown])
    return Table(
        "Table 2: decoders that read the part from straight above",
        ("decoder", *(name for name, *_ in shown)),
        tuple((name, *(column[name] for column in columns)) for name in names),
        (
            f"yes: read in one of {PATIENCE} frames; (print too: no): the flat print is not read either",
            "the paper: five telephones, 28 of 30 read; NeoReader missed CADGraphics on cuboid and bunny",
        ),
    )


def _mark(part: float, flat: float) -> str:
    mark = "yes" if part > 0 else "no"
    return mark if flat > 0 else f"{mark} (print too: no)"
