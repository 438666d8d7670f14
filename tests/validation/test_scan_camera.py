"""The camera against closed forms, against projective geometry, and one renderer against the other."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
import trimesh
from shapely.geometry import box

from perfqr_cad.geometry import Triangles
from perfqr_cad.scan import FlatPrint, Light, Look, Optics, Scene, View, place
from perfqr_cad.scan.camera.camera import Camera, facing_up
from perfqr_cad.scan.camera.skylight import brightness
from perfqr_cad.scan.camera.stack import area, cut_stack

EDGE, SLOT, THICKNESS = 40.0, 4.0, 2.0
NO_FAULTS = Optics(defocus_px=0, noise=0, jpeg_quality=None)


def solid(polygon, thickness: float) -> Triangles:
    mesh = trimesh.creation.extrude_polygon(polygon, thickness)
    return Triangles(mesh.vertices, mesh.faces)


def slotted(thickness: float = THICKNESS) -> Triangles:
    """A plate with one slot of width SLOT along y."""
    half = EDGE / 2
    return solid(box(-half, -half, half, half).difference(box(-SLOT / 2, -15, SLOT / 2, 15)), thickness)


@pytest.mark.parametrize("route", ["sections", "rays"])
@pytest.mark.parametrize("tilt", [0.0, 15.0, 30.0, 45.0, 60.0, 70.0])
def test_visible_dark_width_is_m_minus_h_tan_tilt(route, tilt):
    part = place(slotted())
    scene = Scene(part if route == "sections" else replace(part, flat=False))
    view = View(tilt, 0.0, distance=200.0, size_px=1000)
    shot = scene.shot(view, Look())
    px_per_mm = view.fill * view.size_px / EDGE * np.cos(np.radians(tilt))
    reach = int(0.6 * SLOT * px_per_mm)  # the slot's front edges and a little more
    middle = view.size_px // 2
    visible = (1 - shot.cover[middle, middle - reach : middle + reach + 1]).sum() / px_per_mm
    expected = max(SLOT - THICKNESS * np.tan(np.radians(tilt)), 0.0)
    assert visible == pytest.approx(expected, abs=1.5 / px_per_mm)


def test_a_tilted_print_is_a_homography_of_the_frontal_one():
    rng = np.random.default_rng(4)
    light = np.kron(rng.random((24, 24)) < 0.5, np.ones((40, 40), bool))
    paper = FlatPrint(light, EDGE)
    look = Look(optics=NO_FAULTS)
    view = View(40.0, 60.0, size_px=600)
    frontal = View(0.0, 0.0, size_px=1200, fill=0.98)
    there = Camera(view, facing_up((0, 0, 0), EDGE)).homography(0.0)
    here = Camera(frontal, facing_up((0, 0, 0), EDGE)).homography(0.0)
    import cv2

    warped = cv2.warpPerspective(paper.photo(frontal, look), there @ np.linalg.inv(here), (600, 600))
    centre = there @ [0, 0, 1]
    x, y = (centre[:2] / centre[2]).astype(int)
    window = np.s_[y - 120 : y + 120, x - 120 : x + 120]
    difference = np.abs(warped[window].astype(float) - paper.photo(view, look)[window])
    assert np.median(difference) <= 1
    assert np.mean(difference > 60) < 0.02  # edges only, sampled twice


def test_projected_triangles_give_the_same_silhouette():
    """Independent of both routes: the union of all projected triangles, by shapely."""
    triangles = slotted()
    part = place(triangles)
    view = View(35.0, 25.0, roll_deg=10.0, size_px=400)
    camera = Camera(view, part.code)
    corners = camera.project(triangles.vertices)[triangles.faces]
    union = shapely.union_all([p for p in map(shapely.Polygon, corners) if p.area > 1e-9], grid_size=1e-6)
    for scene in (Scene(part), Scene(replace(part, flat=False))):
        cover = scene.shot(view, Look()).cover
        assert cover.sum() == pytest.approx(union.area, rel=4e-3)
        rows, columns = np.mgrid[5:395:7, 5:395:7]
        clear = np.array([union.boundary.distance(shapely.Point(c, r)) > 1.5 for r, c in
                          zip(rows.ravel(), columns.ravel(), strict=True)])  # fmt: skip
        inside = shapely.contains_xy(union, columns.ravel(), rows.ravel())
        assert np.array_equal(cover[rows.ravel(), columns.ravel()][clear] > 0.5, inside[clear])


def test_sections_and_rays_see_the_same_light():
    part = place(slotted())
    view = View(25.0, 15.0, size_px=500)
    flat, cast = Scene(part).shot(view, Look()), Scene(replace(part, flat=False)).shot(view, Look())
    assert np.mean((flat.cover > 0.5) != (cast.cover > 0.5)) < 0.005
    both = (flat.cover > 0.99) & (cast.cover > 0.99)
    assert flat.material[both].mean() == pytest.approx(cast.material[both].mean(), rel=0.01)
    neither = (flat.cover < 0.01) & (cast.cover < 0.01)
    assert flat.ground[neither].mean() == pytest.approx(cast.ground[neither].mean(), rel=0.04)


@pytest.mark.parametrize("depth", [1.0, 2.0, 4.0])
def test_sky_on_the_floor_of_a_long_slot(depth):
    """View factor from the middle of the floor: 1 / sqrt(1 + (2 d / w)²); walls that reflect nothing."""
    triangles = slotted(depth)
    vertices = triangles.vertices - [0, 0, depth]
    sections = cut_stack(vertices, triangles.faces, edge_mm=EDGE * 1.1, layers=9, pixels=256)
    lit = brightness(sections, Light(ambient=1.0, lamp=0.0), reflectance=0.0)
    middle = lit.ground.shape[0] // 2
    expected = 1 / np.sqrt(1 + (2 * depth / SLOT) ** 2)
    assert lit.ground[middle - 8 : middle + 8, middle].mean() == pytest.approx(expected, abs=0.06)


def test_section_pictures_hold_the_exact_area():
    rng = np.random.default_rng(0)
    polygon = shapely.Polygon([(3.2, 2.1), (17.7, 4.4), (12.3, 18.9), (6.1, 11.0)])
    ring = np.array(polygon.exterior.coords)
    picture = area(np.stack([ring[:-1], ring[1:]], axis=1), (20, 20))
    for row, column in rng.integers(0, 20, (40, 2)):
        expected = polygon.intersection(box(column, row, column + 1, row + 1)).area
        assert picture[row, column] == pytest.approx(expected, abs=1e-6)
