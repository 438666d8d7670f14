import numpy as np
import pytest
from shapely.geometry import Point, box

from perfqr_cad.structure.measure import Discs, locate, von_mises
from perfqr_cad.structure.mesh.gmsh_mesher import triangulate
from perfqr_cad.structure.mesh.seeding import MeshSize, reentrant, seed

SQUARE = triangulate(box(0, 0, 10, 10).difference(box(4, 4, 6, 6)), 1.0)


def corner_values(values: np.ndarray) -> np.ndarray:
    return values[SQUARE.elements[:, :3]]


def averages(values: np.ndarray) -> np.ndarray:
    return Discs(SQUARE, 0.4).matrix(np.arange(SQUARE.corners)) @ values.ravel()


def test_average_of_a_linear_field_is_its_value_at_an_inner_centre() -> None:
    x, y = SQUARE.nodes.T
    averaged = averages(corner_values(2 * x - y))
    inner = np.setdiff1d(np.arange(SQUARE.corners), SQUARE.boundary)
    assert averaged[inner] == pytest.approx((2 * x - y)[inner], abs=0.02)


def test_average_at_the_edge_takes_the_material_side_only() -> None:
    x, _ = SQUARE.nodes.T
    left = int(np.argmin(np.hypot(*(SQUARE.nodes[: SQUARE.corners] - [0, 5]).T)))
    # The centroid of a half disc lies 4r/3π from its flat side.
    assert averages(corner_values(x))[left] == pytest.approx(4 * 0.2 / (3 * np.pi), rel=0.1)


@pytest.mark.parametrize("share", [1.0, 0.6])
def test_hottest_places_are_those_of_averaging_everywhere(share: float) -> None:
    stress = np.random.default_rng(3).normal(size=(len(SQUARE.elements), 3, 2, 5))
    discs = Discs(SQUARE, 1.5)
    every = discs.at(np.arange(SQUARE.corners), stress)
    places, measure = discs.most_stressed(stress, share)
    assert set(places) == set(np.flatnonzero(every >= share * every.max()))
    assert measure == pytest.approx(every[places])
    assert measure[0] == every.max()
    assert every.max() < von_mises(stress).max()


def test_points_in_the_hole_are_not_found() -> None:
    start = np.zeros(2, np.int64)
    element, weights = locate(SQUARE, np.array([[5.0, 5.0], [1.2, 1.3]]), start)
    assert element[0] == -1
    found = SQUARE.elements[element[1], :3]
    assert weights[1] @ SQUARE.nodes[found] == pytest.approx([1.2, 1.3])


def test_neighbours_are_mutual_and_missing_on_the_outline() -> None:
    across = SQUARE.neighbours
    for element, row in enumerate(across):
        assert all(element in across[other] for other in row if other >= 0)
    assert (across < 0).sum() == len(SQUARE.boundary)


def test_von_mises_of_simple_states() -> None:
    assert von_mises(np.array([3.0, 0, 0, 0, 0])) == pytest.approx(3)
    assert von_mises(np.array([0.0, 0, 2, 0, 0])) == pytest.approx(2 * 3**0.5)
    assert von_mises(np.array([5.0, 5, 0, 0, 0])) == pytest.approx(5)


def test_seeds_start_fine_at_reentrant_corners_only() -> None:
    outline = np.array([[0, 0], [10, 0], [10, 10], [5, 10], [5, 5], [0, 5]], float)
    assert reentrant(outline).tolist() == [False, False, False, False, True, False]
    points = seed(outline, np.zeros(6, bool), MeshSize(2.0, 0.25, 0.0, 0.0))
    steps = np.linalg.norm(np.diff(points, axis=0, append=points[:1]), axis=1)
    corner = int(np.flatnonzero((points == [5, 5]).all(axis=1))[0])
    assert steps[corner] == pytest.approx(0.25)
    assert steps[corner - 1] == pytest.approx(0.25)
    assert steps.max() < 3.0
    assert steps[0] == pytest.approx(2.0)


def test_pinned_edges_look_the_same_from_both_sides_and_have_layers_at_walls() -> None:
    square = np.array([[-101, -101], [101, -101], [101, 102], [-101, 102]], float)
    pinned = np.array([True, True, False, False])
    mesh_size = MeshSize(50.0, 50.0, 7.0, 0.0)
    points = seed(square, pinned, mesh_size)
    mirrored = seed(square[::-1], np.array([False, True, True, False]), mesh_size)
    along = {tuple(p) for p in points if p[1] == -101}
    assert along == {tuple(p) for p in mirrored if p[1] == -101}
    assert (-94.0, -101.0) in along
    assert (94.0, -101.0) not in along  # the next edge is a seam too


def test_circle_is_not_refined() -> None:
    disc = np.array(Point(0, 0).buffer(5).exterior.reverse().coords)[:-1]
    assert len(seed(disc, np.zeros(len(disc), bool), MeshSize(2.0, 0.01, 0.0, 0.0))) == len(disc)
