"""Heights at which one nozzle changes its colour."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from perfqr_cad import export, make
from perfqr_cad.errors import DesignError
from perfqr_cad.export.colour_change import colour_changes


def lifted(body, z_mm):
    triangles = body.triangles
    return replace(body, triangles=replace(triangles, vertices=triangles.vertices + np.array([0, 0, z_mm])))


def test_a_part_on_its_backing_changes_where_it_begins(plate):
    [change] = colour_changes(plate.with_backing().solid)
    assert (change.height_mm, change.body) == (1.0, "test-part")
    assert change.words == "change of colour at 1 mm to #EBEBE6 (test-part)"


def test_heights_count_from_the_lowest_body_whatever_their_order(plate):
    solid = plate.with_backing().solid
    [backing] = solid.extras
    turned = replace(backing, extras=(lifted(replace(solid, extras=()), 7.0),))
    assert [c.height_mm for c in colour_changes(turned)] == [8.0]


def test_bodies_that_share_heights_are_refused(plate):
    solid = plate.with_backing().solid
    sunk = replace(solid, extras=(lifted(solid.extras[0], 0.25),))
    with pytest.raises(DesignError, match=r"test-part and backing share 0\.25 mm.*use no --colour-change"):
        colour_changes(sunk)


def test_one_body_has_no_second_colour(plate):
    with pytest.raises(DesignError, match=r"needs a second body"):
        colour_changes(plate.solid)


def test_the_certificate_says_where(plate, tmp_path):
    records = export.write_outputs(
        plate.with_backing(), [tmp_path / "a.3mf", tmp_path / "a.stl"], export.Options(colour_change=True)
    )
    assert records[0].notes == ("change of colour at 1 mm to #EBEBE6 (test-part)",)
    assert records[1].notes == ()


def test_asked_for_without_a_backing_it_is_refused_before_the_work(monkeypatch):
    monkeypatch.setattr("perfqr_cad.pipeline.chain.source", None)
    with pytest.raises(DesignError, match=r"needs a second colour: use --backing 1"):
        make("hi", colour_change=True)


def test_a_made_part_changes_at_the_thickness_of_its_backing(tmp_path):
    made = make("HI", backing_mm=0.8, colour_change=True, freedom="none")
    made.written([tmp_path / "hi.3mf", tmp_path / "hi.json"])
    certificate = json.loads((tmp_path / "hi.json").read_text())
    [change] = certificate["solid"]["colour_changes"]
    assert change["height_mm"] == pytest.approx(0.8)
    assert certificate["files"][0]["notes"] == [
        f"change of colour at 0.8 mm to {change['colour']} (perforated-qr)"
    ]
