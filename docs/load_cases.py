"""Draws docs/img/strength-loads.png: where each load of a hand presses a part, and what is held.

python docs/load_cases.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import shapely
from PIL import Image, ImageDraw
from shapely.geometry.base import BaseGeometry

from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.structure import handling_loads
from perfqr_cad.structure.handling.named_loads import HandlingLoad
from perfqr_cad.structure.handling.pushes import Push, fingertip, pushes, rim
from perfqr_cad.symbol import encode

OUT = Path(__file__).parent / "img" / "strength-loads.png"
EDGE_PX, GAP_PX, TITLE_PX, FINER = 170, 12, 16, 3
MATERIAL, PRESSED, HELD = (205, 205, 200), (214, 69, 65), (66, 113, 174)


def main() -> None:
    """Six panels in a row: pressed in red, held in blue."""
    pattern = build(encode("https://example.com/p/1234567", version=3), PatternSpec(size_mm=60.0))
    loads = handling_loads(())
    panels = [_panel(pattern, load, _push(pattern, load)) for load in loads]
    width = len(panels) * (EDGE_PX + GAP_PX) - GAP_PX
    picture = Image.new("RGB", (width, EDGE_PX + TITLE_PX), "white")
    for k, (panel, load) in enumerate(zip(panels, loads, strict=True)):
        picture.paste(panel, (k * (EDGE_PX + GAP_PX), TITLE_PX))
        ImageDraw.Draw(picture).text((k * (EDGE_PX + GAP_PX), 1), load.name, fill="black")
    picture.quantize(64).save(OUT, optimize=True)


def _push(pattern: Pattern, load: HandlingLoad) -> Push:
    ring = pattern.module_mm * (pattern.symbol.size / 2 - 3.5)
    found = pushes(load, pattern.polygon)
    return found[0] if found else fingertip((-ring, ring), rim(pattern.polygon))


def _panel(pattern: Pattern, load: HandlingLoad, push: Push) -> Image.Image:
    """The part, the region that is pressed and the one that is held."""
    size = FINER * EDGE_PX
    picture = Image.new("RGB", (size, size), "white")
    pressed = pattern.polygon if push.loaded is None else push.loaded
    for region, colour in ((pattern.polygon, MATERIAL), (pressed, PRESSED), (push.held, HELD)):
        mask = _mask(shapely.intersection(pattern.polygon, region), pattern.extent_mm, size)
        share = 150 if region is pressed and push.loaded is None else 255
        picture.paste(colour, mask=mask.point(lambda value, share=share: value * share // 255))
    return picture.resize((EDGE_PX, EDGE_PX), Image.Resampling.LANCZOS)


def _mask(region: BaseGeometry, edge_mm: float, size: int) -> Image.Image:
    mask = Image.new("L", (size, size), 0)
    draw = ImageDraw.Draw(mask)
    for part in shapely.get_parts(region):
        for k, loop in enumerate((part.exterior, *part.interiors) if part.geom_type == "Polygon" else ()):
            points = (np.array(loop.coords) * [1, -1] / edge_mm + 0.5) * size
            draw.polygon([tuple(point) for point in points.tolist()], fill=0 if k else 255)
    return mask


if __name__ == "__main__":
    main()
