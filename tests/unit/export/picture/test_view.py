"""The picture, judged by what must be seen in it. Small pictures: the code path is the same."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from pyzbar import pyzbar

from perfqr_cad.errors import KernelError
from perfqr_cad.export import picture
from perfqr_cad.export.picture import view as view_module
from perfqr_cad.geometry import Triangles
from perfqr_cad.surface import Plane


@pytest.fixture(scope="module")
def view(code):
    return picture.rendered(code, 480, 360)


def test_the_picture_of_a_flat_part_scans(view):
    texts = [found.data for found in pyzbar.decode(view)]
    assert texts == [b"TEXT"]


def test_the_part_fills_the_frame_and_is_centred(view):
    rows, columns = np.nonzero(view[..., 0] > 150)
    assert 0.7 < max(np.ptp(rows) / 360, np.ptp(columns) / 480) < 0.9
    assert (rows.min() + rows.max()) / 2 == pytest.approx(180, abs=8)
    assert (columns.min() + columns.max()) / 2 == pytest.approx(240, abs=8)


def test_holes_show_the_ground_darkened_by_the_walls(view):
    """What is seen through the holes is darker than the open ground: they are open, and occluded."""
    ground = np.median(view[:20, :20].mean(axis=2))
    inside = view[90:270, 140:340].mean(axis=2)
    assert (inside < ground).mean() > 0.05
    assert (inside < 110).mean() < 0.5


def test_no_seam_at_the_border(view):
    """Averaging over tiles must not wrap round from the opposite border."""
    for line, beside in ((view[-1], view[-4]), (view[0], view[3]), (view[:, 0], view[:, 3])):
        assert np.abs(line.astype(int) - beside).max() <= 3


def test_a_curved_part_stands_and_is_lit(wrapped):
    view = picture.rendered(wrapped, 320, 240)
    assert (view[..., 0] > 150).mean() > 0.1
    assert view[:10].max() < 100


def test_same_bytes_again(code, tmp_path, monkeypatch):
    monkeypatch.setattr(view_module, "WIDTH_PX", 200)
    monkeypatch.setattr(view_module, "HEIGHT_PX", 150)
    for name in ("a.png", "b.png"):
        picture.write(code, tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert cv2.imread(str(tmp_path / "a.png")).shape == (150, 200, 3)


def test_backing_closes_the_holes(code):
    """With a red plate behind, the holes are red."""
    plate = code.with_backing()
    red = replace(plate.solid.extras[0], colour=(0.8, 0.02, 0.02))
    closed = replace(plate, solid=replace(plate.solid, extras=(red,)))
    share = [_red_share(picture.rendered(design, 240, 180)) for design in (closed, code)]
    assert share[0] > 0.03
    assert share[1] == 0


def _red_share(view):
    return (view[..., 0].astype(int) - view[..., 1] > 60).mean()


def test_a_part_without_triangles_is_refused(code):
    empty = Triangles(np.zeros((0, 3)), np.zeros((0, 3), int))
    design = replace(code, solid=replace(code.solid, triangles=empty), placement=Plane(1.0))
    with pytest.raises(KernelError, match="0 triangles"):
        picture.rendered(design, 40, 30)
