"""§6, second experiment: six background colours, 20 scans of each code on each, beside the paper's rates."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from perfqr_cad.progress import tell
from perfqr_cad.reproduce.exhibits import exhibits, handheld, rate, save
from perfqr_cad.scan import WHITE, Look, View
from perfqr_cad.scan.colours import BACKGROUNDS, LEAST_CONTRAST, contrast
from perfqr_cad.scan.decoding.decoders import CORE
from perfqr_cad.table import Table

# §6: success rate on each ground, %; white filament, 120 scans each.
PAPER = {"red": 95.8, "green": 96.7, "blue": 98.3, "cyan": 95.8, "magenta": 97.5, "yellow": 94.2}


def run(out: Path, views: int = 20) -> Table:
    """Success by ground: each engine, and the share of scans that at least one engine reads."""
    shown = exhibits(out)
    rows = []
    for ground, paper in PAPER.items():
        tell(f"{ground} ground")
        look = replace(Look(), ground=BACKGROUNDS[ground])
        rates = [rate(e.part, e.payload, handheld(3.0, views, seed=k), look) for k, e in enumerate(shown)]
        mean = {name: 100 * float(np.mean([r[name] for r in rates])) for name in (*CORE, "any")}
        rows.append(
            (ground, contrast(WHITE, look.ground), paper, mean["any"], *(mean[name] for name in CORE))
        )
    part = shown[-1].part
    save(
        out / "colours.png",
        [part.photo_colour(View(10.0, 60.0, size_px=400), Look(ground=BACKGROUNDS[name])) for name in PAPER],
    )
    return Table(
        "Background colours: % of scans read",
        ("ground", "contrast", "paper %", "any engine %", *(f"{name} %" for name in CORE)),
        tuple(rows),
        (
            f"{views} scans of each of {len(shown)} codes, near straight above, one frame a scan",
            f"below a contrast of {LEAST_CONTRAST:g} a part is designed with a warning",
        ),
    )
