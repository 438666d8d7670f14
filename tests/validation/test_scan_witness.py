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
CLEAN = Look(optics=Optics(defocus_px=0, noise=0, jpeg_quality=None), phone=False)
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
    ground: float = 0.0  # reflectance
    bounces: int = 8

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
        """Of each point (k,): lamp and sky, and what part and ground throw back."""
        pairs = zip(points, normals, strict=True)
        return np.array([
            self.received(np.tile(point, (paths, 1)), np.tile(normal, (paths, 1)), rng, self.bounces).mean()
            for point, normal in pairs
        ])  # fmt: skip

    def received(self, points, normals, rng, bounces: int) -> np.ndarray:
        """Light on each point (k,): the lamps', and what one way brings, from the sky or after bounces."""
        ways = rng.normal(size=points.shape)
        ways = ways / np.linalg.norm(ways, axis=1, keepdims=True) + normals  # as likely as their cosine
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        start = points + 1e-4 * normals
        met, far = self.hit(start, ways)
        down = ways[:, 2] < 0
        total = self.lamp(points, normals) + self.light.ambient * ((met < 0) & ~down)
        on_ground = (met < 0) & down & (self.ground > 0)
        lit = (met >= 0) | on_ground
        if bounces and lit.any():
            with np.errstate(divide="ignore"):
                far = np.where(on_ground, (self.floor - start[:, 2]) / ways[:, 2], far)[lit]
            where, facing = start[lit] + far[:, None] * ways[lit], self.normals(met[lit], ways[lit])
            sent = np.where(on_ground[lit], self.ground, REFLECTANCE)
            total[lit] += sent * self.received(where, facing, rng, bounces - 1)
        return total

    def lamp(self, points, normals) -> np.ndarray:
        total = np.zeros(len(points))
        for towards in self.light.lamp_directions:
            met, _ = self.hit(points + 1e-4 * normals, np.tile(towards, (len(points), 1)))
            total += np.maximum(normals @ towards, 0) * (met < 0) * self.near(points, towards)
        return self.light.lamp / self.light.lamp_sides * total

    def near(self, points, towards) -> np.ndarray:
        """What a near lamp gives a point over what it gives the centre, for a level face."""
        if np.isinf(self.light.lamp_distance):
            return np.ones(len(points))
        off = self.light.lamp_distance * EDGE * towards - points * [1, 1, 0]
        away = np.linalg.norm(off, axis=1)
        cosine = off[:, 2] / away / towards[2]
        return (self.light.lamp_distance * EDGE / away) ** 2 * cosine

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


def witnessed(triangles: Triangles, view: View, pixels: np.ndarray, look: Look = CLEAN) -> Seen:
    vertices = np.asarray(triangles.vertices)
    ground, floor = look.ground[0], float(vertices[:, 2].min()) - look.gap_mm
    bright = ground > 0.1  # else its light is left out, as in the camera
    witness = Witness(vertices[triangles.faces], look.light, floor, ground if bright else 0.0)
    eye, ways = pinhole(view, EDGE, float(vertices[:, 2].max()))
    return witness.look(eye, ways[tuple(pixels.T)], np.random.default_rng(5))


def filmed(scene: Scene, view: View, pixels: np.ndarray, look: Look = CLEAN) -> tuple[np.ndarray, np.ndarray]:
    """Of the pixels (k, 2) of the camera: how much of them is material, and their light."""
    shot = scene.shot(view, look)
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


WHITE_GROUND = replace(CLEAN, ground=(0.8, 0.8, 0.8))
LIGHTS = {
    "white ground, touching": WHITE_GROUND,
    "white ground, 5 mm behind": replace(WHITE_GROUND, gap_mm=5.0),
    "four lamps": replace(
        WHITE_GROUND, light=Light(0.0, 1.4, lamp_azimuth_deg=45.0, lamp_elevation_deg=45.0, lamp_sides=4)
    ),
    "a low near lamp": replace(CLEAN, light=Light(0.2, 1.0, lamp_elevation_deg=35.0, lamp_distance=2.0)),
}


@pytest.mark.parametrize("route", ["sections", "rays"])
@pytest.mark.parametrize("name", LIGHTS)
def test_light_that_a_bright_ground_sends_up_and_light_of_near_lamps(name, route):
    look = LIGHTS[name]
    seen = witnessed(plate(), PLATE_VIEW, ACROSS[::2], look)
    scene = Scene(replace(place(plate()), flat=route == "sections"))
    cover, light = filmed(scene, PLATE_VIEW, ACROSS[::2], look)
    clear = ((cover < 0.01) | (cover > 0.99)) & ((cover > 0.5) == seen.on_part)
    kinds = {
        "front": seen.points[:, 2] > 1.99,
        "ground": ~seen.on_part,
        "wall": seen.normals[:, 0] > 0.5,
    }
    off = {
        kind: (float(light[chosen & clear].mean()), float(seen.light[chosen & clear].mean()))
        for kind, chosen in kinds.items()
    }
    for kind, (ours, theirs) in off.items():
        assert ours == pytest.approx(theirs, abs=0.09), (kind, off)


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
