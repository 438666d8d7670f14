"""What the paper leaves open: how far each fault of a scan may go, for all engines and for any."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.progress import tell
from perfqr_cad.reproduce.exhibits import Exhibit, default_part, rate, save
from perfqr_cad.scan import Light, Look, Optics, Scene, View
from perfqr_cad.scan.decoding.decoders import CORE
from perfqr_cad.table import Table

SIDE_DEG = 25.0  # azimuth and a slight tilt, so that nothing is square to the picture
TILT_DEG = 5.0
BLURS_PX = (1, 4, 8, 12, 16, 20, 24, 30)


@dataclass(frozen=True)
class Occluded:
    """A part with a finger over a corner: a gray disc, its diameter a part of the code's edge."""

    scene: Scene
    diameter: float

    def prepare(self, look: Look) -> None:
        self.scene.prepare(look)

    def photo(self, view: View, look: Look | None = None, *, seed: int = 0) -> NDArray[np.uint8]:
        import cv2

        picture = self.scene.photo(view, look, seed=seed).copy()
        edge = view.fill * view.size_px
        centre = round(view.size_px / 2 + 0.36 * edge)
        cv2.circle(picture, (centre, centre), round(self.diameter * edge / 2), 150, -1, cv2.LINE_AA)
        return picture


@dataclass(frozen=True)
class Fault:
    """A series of ever worse values and how each is filmed."""

    name: str
    unit: str
    values: Sequence[float]
    scene: Callable[[Exhibit, float], tuple[Scene | Occluded, View, Look]]


def run(out: Path, views: int = 3) -> Table:
    """The worst value still read by all engines and by any, part and print apart."""
    shown = default_part()
    rows: list[tuple[object, ...]] = []
    pictures: list[NDArray[np.uint8]] = []
    for fault in _FAULTS:
        tell(fault.name)
        rates: list[dict[str, float]] = []
        for value in fault.values:
            subject, view, look = fault.scene(shown, value)
            seen = [replace(view, azimuth_deg=SIDE_DEG + 120 * k) for k in range(views)]
            rates.append(rate(subject, shown.payload, seen, look))  # type: ignore[arg-type]
        each = [_worst(fault.values, [r[name] for r in rates]) for name in CORE]
        by_all = _worst(fault.values, [min(r[name] for name in CORE) for r in rates])
        rows.append((fault.name, fault.unit, by_all, _worst(fault.values, [r["any"] for r in rates]), *each))
        subject, view, look = fault.scene(shown, fault.values[len(fault.values) // 2])
        pictures.append(_thumbnail(subject.photo(replace(view, azimuth_deg=SIDE_DEG), look)))
    save(out / "limits.png", pictures)
    return Table(
        "Limits: the worst value up to which every scan is read",
        ("fault", "unit", "by all", "by any", *CORE),
        tuple(rows),
        (f"module {shown.pattern.module_mm:.3g} mm, {TILT_DEG:g}° tilt from {views} sides, default part",),
    )


def _worst(values: Sequence[float], rates: Sequence[float]) -> float | None:
    """The last value of the series before the first miss."""
    reached = None
    for value, share in zip(values, rates, strict=True):
        if share < 1:
            break
        reached = value
    return reached


def _thumbnail(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    import cv2

    return np.asarray(cv2.resize(picture, (220, 220), interpolation=cv2.INTER_AREA), np.uint8)


_VIEW = View(TILT_DEG, SIDE_DEG, size_px=800)


def _camera(exhibit: Exhibit, **optics: float) -> tuple[Scene, View, Look]:
    return exhibit.part, _VIEW, Look(optics=replace(Optics(), **optics))  # type: ignore[arg-type]


def _module_px(exhibit: Exhibit, pixels: float) -> tuple[Scene, View, Look]:
    modules = exhibit.pattern.size_mm / exhibit.pattern.module_mm
    return exhibit.part, replace(_VIEW, size_px=max(round(pixels * modules / _VIEW.fill), 16)), Look()


def _far(exhibit: Exhibit, times: float) -> tuple[Scene, View, Look]:
    return exhibit.part, replace(_VIEW, fill=_VIEW.fill / times, distance=_VIEW.distance * times), Look()


def _side_light(exhibit: Exhibit, lamp: float) -> tuple[Scene, View, Look]:
    return exhibit.part, _VIEW, Look(light=Light(ambient=0.2, lamp=lamp, lamp_elevation_deg=20.0))


def _busy(exhibit: Exhibit, depth: float) -> tuple[Scene, View, Look]:
    """A coarse random pattern of a given depth on a grey ground."""
    rng = np.random.default_rng(3)
    texture = (1 + depth * rng.uniform(-1, 1, (12, 12))).astype(np.float32)
    ground = (0.3, 0.3, 0.3)
    return exhibit.part, _VIEW, Look(ground=ground, texture=texture, gap_mm=5.0)


_FAULTS = (
    Fault("resolution", "px a module", (12, 8, 6, 5, 4, 3.5, 3, 2.5, 2), _module_px),
    Fault("distance", "times", (1, 2, 3, 4, 5, 6, 8), _far),
    Fault("defocus", "px", BLURS_PX, lambda e, v: _camera(e, defocus_px=v)),
    Fault("motion", "px", BLURS_PX, lambda e, v: _camera(e, motion_px=v, motion_deg=20.0)),
    Fault("noise", "of full scale", (0.01, 0.03, 0.06, 0.1, 0.2, 0.3), lambda e, v: _camera(e, noise=v)),
    Fault("side light at 20°", "times the sky", (1, 2, 4, 8), _side_light),
    Fault("busy ground", "depth", (0.0, 0.25, 0.5, 0.75, 1.0), _busy),
    Fault("occluded corner", "of the edge", (0.0, 0.08, 0.12, 0.16, 0.2, 0.25, 0.3),
          lambda e, v: (Occluded(e.part, v), _VIEW, Look())),
)  # fmt: skip
