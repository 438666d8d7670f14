"""The camera beside a second renderer: every ray against every triangle, every path by Monte Carlo.

Nothing is shared with the camera but the meaning of a view, a light and a mesh: intersections are
Möller & Trumbore's (1997), light is integrated pixel by pixel and not averaged over neighbours.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import trimesh
from shapely.geometry import box

from perfqr_cad.geometry import Triangles
from perfqr_cad.scan import Light, Look, Optics, Scene, View, place

REFLECTANCE = 0.85  # of the default look
PATHS = 150  # a pixel; means over twenty pixels and more are compared
CLEAN = Look(optics=Optics(defocus_px=0, noise=0, jpeg_quality=None))
EDGE = 40.0


def meshed(polygon, low: float, high: float) -> trimesh.Trimesh:
    mesh = trimesh.creation.extrude_polygon(polygon, high - low)
    return mesh.apply_translation([0, 0, low])


def plate() -> Triangles:
    """A plate of 2 mm with a slot of 4 mm and a square hole of 6 mm, one of whose sides has a ledge."""
    half = EDGE / 2
    outline = box(-half, -half, half, half)
    slot, hole, ledge = box(-8, -12, -4, 12), box(2, -3, 8, 3), box(2, -3, 8, -1)
    upper = meshed(outline.difference(slot.union(hole)), 0.6, 2.0)
    lower = meshed(outline.difference(slot.union(hole.difference(ledge))), 0.0, 0.6)
    return Triangles(*joined(upper, lower))


def hollow_box() -> Triangles:
    """A box of 20 mm height, walls of 1.5 mm, with a window of 12 mm in its top."""
    half = EDGE / 2
    outline = box(-half, -half, half, half)
    walls = outline.difference(outline.buffer(-1.5, join_style="mitre"))
    lid = outline.difference(box(-6, -6, 6, 6))
    return Triangles(*joined(meshed(outline, 0, 1.5), meshed(walls, 1.5, 18.5), meshed(lid, 18.5, 20)))


def joined(*pieces: trimesh.Trimesh):
    whole = trimesh.boolean.union(list(pieces), engine="manifold")
    return whole.vertices, whole.faces


@dataclass(frozen=True)
class Seen:
    """Of k pixels: whether they show the part, the place (k, 3), its normal (k, 3), and the light on it."""

    on_part: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    light: np.ndarray


@dataclass(frozen=True)
class Witness:
    corners: np.ndarray
    light: Light
    floor: float

    def hit(self, origins: np.ndarray, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nearest triangle (-1: none) and how far, for rays (k, 3); all against all."""
        start, one, two = self.corners[:, 0], *np.moveaxis(self.corners[:, 1:] - self.corners[:, :1], 1, 0)
        p = np.cross(ways[:, None], two)
        volume = np.einsum("kmi,mi->km", p, one)
        from_start = origins[:, None] - start
        q = np.cross(from_start, one)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("kmi,kmi->km", from_start, p) / volume
            v = np.einsum("kmi,ki->km", q, ways) / volume
            far = np.einsum("kmi,mi->km", q, two) / volume
        far[~((u >= 0) & (v >= 0) & (u + v <= 1) & (far > 1e-6))] = np.inf
        nearest = far.argmin(axis=1)
        distance = far[np.arange(len(far)), nearest]
        return np.where(np.isfinite(distance), nearest, -1), distance

    def normals(self, triangle: np.ndarray, ways: np.ndarray) -> np.ndarray:
        """Unit normals against the ways; upwards where nothing was met."""
        corner = self.corners[triangle]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        normal[triangle < 0] = [0, 0, 1]
        return normal * -np.sign(np.einsum("ki,ki->k", normal, ways))[:, None]

    def irradiance(self, points, normals, rng, paths: int) -> np.ndarray:
        """Of each point (k,): lamp and sky, and what the part throws back once."""
        total = np.zeros(len(points))
        for point, normal, k in zip(points, normals, range(len(points)), strict=True):
            origin = np.tile(point + 1e-4 * normal, (paths, 1))
            ways = rng.normal(size=(paths, 3))
            ways = ways / np.linalg.norm(ways, axis=1, keepdims=True) + normal  # as likely as their cosine
            ways /= np.linalg.norm(ways, axis=1, keepdims=True)
            met, far = self.hit(origin, ways)
            open_sky = (met < 0) & (ways[:, 2] > 0)
            total[k] = self.lamp(origin[:1], normal[None])[0] + self.light.ambient * open_sky.mean()
            if (met >= 0).any():
                lit = met >= 0
                where, facing = origin[lit] + far[lit, None] * ways[lit], self.normals(met[lit], ways[lit])
                total[k] += REFLECTANCE * self.thrown_back(where, facing, rng).sum() / paths
        return total

    def thrown_back(self, points, normals, rng) -> np.ndarray:
        """Direct light of each point, one sky ray each."""
        ways = rng.normal(size=points.shape)
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True) + normals
        met, _ = self.hit(points + 1e-4 * normals, ways)
        sky = self.light.ambient * ((met < 0) & (ways[:, 2] > 0))
        return sky + self.lamp(points, normals)

    def lamp(self, points, normals) -> np.ndarray:
        towards = self.light.lamp_direction
        met, _ = self.hit(points + 1e-4 * normals, np.tile(towards, (len(points), 1)))
        return self.light.lamp * np.maximum(normals @ towards, 0) * (met < 0)

    def look(self, eye, ways, rng) -> Seen:
        """What each way meets, and the light there."""
        met, far = self.hit(np.tile(eye, (len(ways), 1)), ways)
        far = np.where(met >= 0, far, (self.floor - eye[2]) / ways[:, 2])
        points, normals = eye + far[:, None] * ways, self.normals(met, ways)
        return Seen(met >= 0, points, normals, self.irradiance(points, normals, rng, PATHS))


def pinhole(view: View, edge: float, top: float) -> tuple[np.ndarray, np.ndarray]:
    """Eye and ways (n, n, 3) through the pixels, from what `View` says in words."""
    tilt, azimuth = np.radians([view.tilt_deg, view.azimuth_deg])
    out = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
    right = np.cross([0.0, 1.0, 0.0], out)
    right /= np.linalg.norm(right)
    up = np.cross(out, right)
    half = edge / view.fill / 2
    at = (np.arange(view.size_px) + 0.5) / view.size_px * 2 - 1
    ways = half * (at[:, None, None] * -up + at[:, None] * right) - view.distance * edge * out
    return np.array([0, 0, top]) + view.distance * edge * out, ways


def witnessed(triangles: Triangles, view: View, pixels: np.ndarray) -> Seen:
    vertices = np.asarray(triangles.vertices)
    witness = Witness(vertices[triangles.faces], CLEAN.light, float(vertices[:, 2].min()))
    eye, ways = pinhole(view, EDGE, float(vertices[:, 2].max()))
    return witness.look(eye, ways[tuple(pixels.T)], np.random.default_rng(5))


def filmed(scene: Scene, view: View, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the pixels (k, 2) of the camera: how much of them is material, and their light."""
    shot = scene.shot(view, CLEAN)
    at = tuple(pixels.T)
    return shot.cover[at], (shot.material + shot.ground)[at]


PLATE_VIEW = View(30.0, 25.0, size_px=240)
ACROSS = np.stack(np.mgrid[104:138:3, 78:162:2], axis=-1).reshape(-1, 2)  # slot, ledge and hole


@pytest.fixture(scope="module")
def plate_seen() -> Seen:
    return witnessed(plate(), PLATE_VIEW, ACROSS)


@pytest.mark.parametrize("route", ["sections", "rays"])
def test_pixels_of_a_plate_are_those_of_the_witness(route, plate_seen):
    part = place(plate())
    assert part.flat
    cover, light = filmed(Scene(replace(part, flat=route == "sections")), PLATE_VIEW, ACROSS)
    clear = (cover < 0.01) | (cover > 0.99)  # pixels are areas here, points there
    assert clear.mean() > 0.9
    assert np.mean((cover > 0.5) == plate_seen.on_part, where=clear) > 0.99
    clear &= (cover > 0.5) == plate_seen.on_part
    facing, high = plate_seen.normals, plate_seen.points[:, 2] > 1.99
    kinds = {
        "front": (high, 0.02),
        "ledge": (plate_seen.on_part & (facing[:, 2] > 0.5) & ~high, 0.06),
        "ground": (~plate_seen.on_part, 0.08),
        "wall": (facing[:, 0] > 0.5, 0.08),
    }
    for kind, (chosen, within) in kinds.items():
        chosen = chosen & clear
        assert chosen.sum() >= 20, kind
        assert light[chosen].mean() == pytest.approx(plate_seen.light[chosen].mean(), abs=within), kind
        assert np.abs(light - plate_seen.light)[chosen].mean() < 0.12, kind


def test_the_inside_of_a_hollow_body_stays_dark_up_to_the_edge_of_its_window():
    triangles, view = hollow_box(), View(0.0, 0.0, size_px=240)
    inside = round((0.5 + 6 / EDGE * view.fill - 0.02) * view.size_px)  # close to the window's edge
    pixels = np.array([(120, c) for c in range(80, 200, 3)] + [(120, inside), (inside, 120)])
    seen = witnessed(triangles, view, pixels)
    cover, light = filmed(Scene(place(triangles)), view, pixels)
    assert seen.on_part.all()
    assert np.all(cover > 0.5)
    deep = seen.light < 0.7 * CLEAN.light.on_front
    assert 5 < deep.sum() < len(pixels) - 5
    assert deep[-2:].all()
    assert np.abs(light - seen.light)[deep].max() < 0.15
    assert np.abs(light - seen.light)[~deep].max() < 0.1
