"""The proof: film the part from many sides and count who reads exactly what it should say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from perfqr_cad.progress import tell
from perfqr_cad.scan.camera import View
from perfqr_cad.scan.decoders import CORE, accepted
from perfqr_cad.scan.look import Look
from perfqr_cad.scan.panel import Panel
from perfqr_cad.scan.part import place
from perfqr_cad.scan.report import DecoderResult, ScanReport
from perfqr_cad.scan.scene import Scene, jittered
from perfqr_cad.surface import Placement, Triangles

if TYPE_CHECKING:
    from perfqr_cad.pattern import Pattern

FRAMES = 3  # a phone tries many frames in the paper's 2 s; a miss is three frames of an unsteady hand missed


def certify(
    triangles: Triangles,
    placement: Placement | None,
    pattern: Pattern | None,
    payload: str | bytes,
    *,
    decoders: Sequence[str] = CORE,
    tilts: Sequence[float] = (0, 20, 30, 45),
    azimuths: Sequence[float] = (20, 110, 200, 290),
    look: Look | None = None,
    frames: int = FRAMES,
    seed: int = 0,
) -> ScanReport:
    """Film a solid before a dark ground and report which decoders read the exact payload.

    Without a placement the reader looks down on the top of the mesh. AnalysisError if a decoder is not
    available here; KernelError if the mesh is empty.
    """
    tell("scan")
    edge = None if pattern is None else pattern.size_mm
    scene = Scene(place(triangles, placement, edge_mm=edge))
    views = [View(t, a) for t in tilts for a in (azimuths if t > 0 else azimuths[:1])]
    with Panel(decoders) as panel:
        read = _reads(scene, views, look or Look(), accepted(payload), panel, frames, seed)
    results = {}
    for name in decoders:
        rates = tuple(
            float(np.mean([name in names for view, names in zip(views, read, strict=True) if view.tilt_deg == t]))
            for t in tilts
        )
        results[name] = DecoderResult(name, tuple(map(float, tilts)), rates, rates)
    return ScanReport(results, {"black": float(np.mean([len(names) > 0 for names in read]))})


def _reads(
    scene: Scene, views: Sequence[View], look: Look, right: frozenset[bytes], panel: Panel, frames: int, seed: int
) -> list[frozenset[str]]:
    """Which decoders read each view, each given up to `frames` frames."""
    read: list[set[str]] = [set() for _ in views]
    for frame in range(frames):
        waiting = [k for k in range(len(views)) if len(read[k]) < len(panel.names)]
        pictures = []
        for k in waiting:
            rng = np.random.default_rng([seed, k, frame])
            view = jittered(views[k], rng) if frame else views[k]
            pictures.append(scene.photo(view, look, seed=seed + 1000 * k + frame))
        names = [[name for name in panel.names if name not in read[k]] for k in waiting]
        for k, reading in zip(waiting, panel.read_all(pictures, names=names), strict=True):
            read[k] |= {name for name, payloads in reading.items() if right.intersection(payloads)}
    return [frozenset(names) for names in read]
