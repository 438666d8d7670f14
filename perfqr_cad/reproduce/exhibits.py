"""The paper's five codes as parts before the camera, each beside its flat print."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.capture import Capture
from perfqr_cad.errors import DesignError
from perfqr_cad.pattern import Pattern, PatternSpec, build
from perfqr_cad.progress import tell
from perfqr_cad.reproduce.stand_ins import TABLE_1, THICKNESS_MM, Row, picture
from perfqr_cad.scan import FlatPrint, Look, Scene, View, place, printed, reads
from perfqr_cad.scan.camera.scene import jittered
from perfqr_cad.scan.decoding.decoders import CORE, accepted
from perfqr_cad.scan.decoding.panel import shared
from perfqr_cad.surface import Plane

DEFAULT_TEXT = "https://example.com/p/1234567"


@dataclass(frozen=True)
class Exhibit:
    """One code: its payload, the part, and the picture that was asked for printed flat at the same size."""

    name: str
    payload: bytes
    part: Scene
    print: FlatPrint
    pattern: Pattern


def exhibits(out: Path) -> list[Exhibit]:
    """All five, in the paper's order."""
    return [exhibit(row.name, out) for row in TABLE_1]


@lru_cache(maxsize=8)
def exhibit(name: str, out: Path) -> Exhibit:
    """One by its name in Table 1."""
    from perfqr_cad.solid import build as build_solid

    row = next(row for row in TABLE_1 if row.name == name)
    tell(f"make {name}")
    captured, pattern = captured_pattern(row, out)
    placement = Plane(THICKNESS_MM)
    solid = build_solid(pattern, placement)
    art = captured.art
    paper = printed(art.dark, pattern.size_mm, quiet_modules=pattern.quiet_modules, scale=art.scale)
    scene = Scene(place(solid.triangles, placement, edge_mm=pattern.size_mm))
    return Exhibit(name, captured.recovery.payload.data, scene, paper, pattern)


@lru_cache(maxsize=1)
def default_part() -> Exhibit:
    """What `perfqr make` gives without settings: a plain version-5 code on 60 mm."""
    from perfqr_cad.pipeline.chain import make

    design = make(text=DEFAULT_TEXT, version=5, size_mm=60.0)
    pattern = design.pattern
    paper = printed(design.symbol.matrix.dark, pattern.size_mm, quiet_modules=pattern.quiet_modules)
    scene = Scene(place(design.solid.triangles, design.placement, edge_mm=pattern.size_mm))
    return Exhibit("default", DEFAULT_TEXT.encode(), scene, paper, pattern)


def captured_pattern(row: Row, out: Path) -> tuple[Capture, Pattern]:
    """The stand-in as it is read, and its pattern."""
    from perfqr_cad.capture import read

    captured = read(picture(row, out))
    return captured, pattern_of(captured, row)


def pattern_of(captured: Capture, row: Row) -> Pattern:
    """The pattern at the paper's size, or at the least that the nozzle can make."""
    symbol = captured.recovery.symbol
    try:
        return build(symbol, PatternSpec(size_mm=row.size_mm), captured.art)
    except DesignError:  # smaller than the nozzle can make
        return build(symbol, PatternSpec(), captured.art)


def rate(
    subject: Scene | FlatPrint,
    payload: bytes,
    views: Sequence[View],
    look: Look,
    *,
    names: Sequence[str] = CORE,
    seed: int = 0,
) -> dict[str, float]:
    """Share of the views that each decoder reads, one frame each, and under `any` what at least one does."""
    read = reads(subject, views, look, accepted(payload), shared(names), seed=seed)
    rates = {name: float(np.mean([name in who for who in read])) for name in names}
    return rates | {"any": float(np.mean([len(who) > 0 for who in read]))}


def handheld(tilt_deg: float, count: int, seed: int, size_px: int = 800) -> list[View]:
    """`count` views at one tilt, from any side, by an unsteady hand."""
    rng = np.random.default_rng([seed, round(10 * tilt_deg)])
    return [jittered(View(tilt_deg, float(rng.uniform(0, 360)), size_px=size_px), rng) for _ in range(count)]


def save(path: Path, pictures: Sequence[NDArray[np.uint8]]) -> None:
    """Write pictures side by side as one PNG; gray or red-first colour, of one height."""
    import cv2

    path.parent.mkdir(parents=True, exist_ok=True)
    row = np.hstack([p if p.ndim == 3 else np.repeat(p[..., None], 3, axis=2) for p in pictures])
    cv2.imwrite(str(path), row[..., ::-1])
