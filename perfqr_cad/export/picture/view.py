"""A picture of the part: the solid itself on a dark ground, in soft light, with its holes open."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import KernelError
from perfqr_cad.export.design_view import DesignView
from perfqr_cad.export.picture.tone import exposed
from perfqr_cad.geometry import Triangles
from perfqr_cad.units import linear_from_srgb

if TYPE_CHECKING:
    from perfqr_cad.export.picture.raycast import Viewpoint
    from perfqr_cad.surface import Placement

WIDTH_PX, HEIGHT_PX = 1040, 780
GROUND = (0.225, 0.25, 0.285)  # sRGB: slate, dark enough for the holes to read as the dark tone
TILT_DEG, TURN_DEG = 33.0, -24.0  # of the view from the code's normal, and about it
UPRIGHT_TILT_DEG, UPRIGHT_TURN_DEG = 16.0, 24.0  # above the horizon and to the side, for curved parts
SPREAD = 0.20  # tangent of half the picture's width: a long lens, little perspective
UP_LYING, UP_UPRIGHT = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
KEY_LYING, KEY_UPRIGHT = (-0.46, 0.42, 0.78), (-0.45, 0.5, 0.74)  # towards the light
LIFT = 2e-4  # of the part's size: gap above the ground, and start of a secondary ray above its surface
FILL = 0.84  # share of the frame that the part takes
FIT_STEPS = 12  # of the camera: each divides the error by about ten
GROUND_EXTENT = 60.0  # of the part's size: beyond the picture's edge


def write(design: DesignView, path: Path) -> None:
    """Write the picture; the same part gives the same bytes.

    Raises `KernelError` for a part without a mesh.
    """
    import cv2

    image = rendered(design, WIDTH_PX, HEIGHT_PX)
    _, data = cv2.imencode(".png", image[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 9])
    path.write_bytes(data.tobytes())


def rendered(design: DesignView, width: int, height: int) -> NDArray[np.uint8]:
    """The picture as sRGB (height, width, 3): a flat part lies on the ground, a curved one stands on it."""
    from perfqr_cad.export.picture.raycast import Lighting, LitMesh, render

    bodies = [design.solid, *design.solid.extras]
    if not len(design.solid.triangles.faces):
        raise KernelError(f"{design.solid.name}: a mesh of 0 triangles has no picture; build the solid again")
    lies = design.placement.is_flat
    part = _seen_by_reader(bodies[0].triangles.joined(*(b.triangles for b in bodies[1:])), design.placement)
    ground = _ground(part.vertices, up=2 if lies else 1)
    counts = [*(len(body.triangles.faces) for body in bodies), len(ground.faces)]
    colours = np.repeat([*(body.colour for body in bodies), GROUND], counts, axis=0)
    lighting = Lighting(UP_LYING, KEY_LYING) if lies else Lighting(UP_UPRIGHT, KEY_UPRIGHT)
    camera = _camera(part.vertices, lies, width / height)
    scene = LitMesh(part.joined(ground), linear_from_srgb(colours))
    return exposed(_vignette(render(scene, camera, lighting, width, height, LIFT * _size(part.vertices))))


def _seen_by_reader(mesh: Triangles, placement: Placement) -> Triangles:
    """The mesh turned so that at the code's centre x is right, y is up and z is towards the reader."""
    return Triangles(mesh.vertices @ placement.reader_axes().T, mesh.faces)


def _camera(points: NDArray[Any], lies: bool, aspect: float) -> Viewpoint:
    """The view from the side that shows the holes, centred on the part and just far enough."""
    from perfqr_cad.export.picture.raycast import Viewpoint

    if lies:
        tilt, turn = np.radians([TILT_DEG, TURN_DEG])
        away = np.array([-np.sin(tilt) * np.sin(turn), -np.sin(tilt) * np.cos(turn), np.cos(tilt)])
    else:
        tilt, turn = np.radians([UPRIGHT_TILT_DEG, UPRIGHT_TURN_DEG])
        away = np.array([np.sin(turn) * np.cos(tilt), np.sin(tilt), np.cos(turn) * np.cos(tilt)])
    target, distance = (points.min(axis=0) + points.max(axis=0)) / 2, 3.0 * _size(points)

    def camera() -> Viewpoint:
        return Viewpoint(target + away * distance, target, np.array([0.0, 1.0, 0.0]), SPREAD)

    for _ in range(FIT_STEPS):  # fixed point: centre what is seen, then step back until it fits
        right, above, forward = camera().axes()
        seen = points - camera().eye
        depth = (seen @ forward) * SPREAD
        x, y = seen @ right / depth, seen @ above / depth * aspect
        off_x, off_y = (x.max() + x.min()) / 2, (y.max() + y.min()) / 2 / aspect
        target = target + (right * off_x + above * off_y) * SPREAD * distance
        distance *= max(np.ptp(x), np.ptp(y)) / 2 / FILL
    return camera()


def _ground(points: NDArray[Any], up: int) -> Triangles:
    """Two triangles just under the part; `up` is the axis that they face along."""
    low, high = points.min(axis=0), points.max(axis=0)
    right, back = (0, 1) if up == 2 else (2, 0)
    reach = _size(points) * GROUND_EXTENT
    corners = np.tile((low + high) / 2, (4, 1))
    corners[:, up] = low[up] - LIFT * _size(points)
    corners[:, right] += np.array([-1, 1, 1, -1]) * reach
    corners[:, back] += np.array([-1, -1, 1, 1]) * reach
    return Triangles(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def _size(points: NDArray[Any]) -> float:
    return float(np.ptp(points, axis=0).max())


def _vignette(shade: NDArray[Any]) -> NDArray[Any]:
    """Slightly darker corners, as a lens gives."""
    height, width = shade.shape[:2]
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    return shade * (1 - 0.16 * np.minimum(x * x + y * y, 2.0))[..., None]
