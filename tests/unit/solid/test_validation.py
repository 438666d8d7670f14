"""Validation properties as the modeller's own reader finds them, against what it measures on the shapes."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDF import TDF_AttributeIterator, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFDoc import (
    XCAFDoc_Area,
    XCAFDoc_Centroid,
    XCAFDoc_DocumentTool,
    XCAFDoc_ShapeTool,
    XCAFDoc_Volume,
)

from perfqr_cad.geometry.outline import Circle, Loop, Region
from perfqr_cad.profile import Profile, Walls
from perfqr_cad.solid import Solid, build_profile, write_step
from perfqr_cad.solid.step.validation import measured
from perfqr_cad.surface import Cylinder, Plane

OUTER = Loop.from_points([(-8, -8), (8, -8), (8, 8), (-8, 8)])
HOLE = Loop((Circle((4, 3), 1.5, ccw=False),))
KINDS = {XCAFDoc_Volume: "volume", XCAFDoc_Area: "area", XCAFDoc_Centroid: "centroid"}


def part(placement=None, walls=None) -> Solid:
    return build_profile(Profile((Region(OUTER, (HOLE,)),)), placement or Plane(2.0), walls)


def stated_and_measured(path: Path):
    """For each part in a file its properties, and the volume, area and centroid of its shape."""
    reader = STEPCAFControl_Reader()
    reader.SetPropsMode(True)
    reader.ReadFile(os.fspath(path))
    document = TDocStd_Document(TCollection_ExtendedString("test"))
    reader.Transfer(document)
    labels = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetShapes(labels)
    found = []
    for label in (labels.Value(k + 1) for k in range(labels.Length())):
        if XCAFDoc_ShapeTool.IsAssembly_s(label):
            continue
        stated, attributes = {}, TDF_AttributeIterator(label)
        while attributes.More():
            attribute = attributes.Value()
            if type(attribute) in KINDS:
                stated[KINDS[type(attribute)]] = attribute.Get()
            attributes.Next()
        shape = XCAFDoc_ShapeTool.GetShape_s(label)
        inside, skin = GProp_GProps(), GProp_GProps()
        BRepGProp.VolumeProperties_s(shape, inside)
        BRepGProp.SurfaceProperties_s(shape, skin)
        found.append((stated, inside.Mass(), skin.Mass(), inside.CentreOfMass()))
    return found


def coordinates(point):
    return [point.X(), point.Y(), point.Z()]


@pytest.mark.parametrize(
    ("placement", "walls"),
    [(Plane(2.0), None), (Plane(2.0), Walls(draft_deg=10.0, lip_mm=0.4)), (Cylinder(30.0, 2.0), None)],
)
def test_what_is_stated_is_what_the_modeller_measures(placement, walls, tmp_path):
    write_step(part(placement, walls), tmp_path / "part.step")
    [(stated, volume, area, centroid)] = stated_and_measured(tmp_path / "part.step")
    assert stated["volume"] == pytest.approx(volume, rel=1e-6)
    assert stated["area"] == pytest.approx(area, rel=1e-3)  # by triangles, chords of 0.01 mm
    assert coordinates(stated["centroid"]) == pytest.approx(coordinates(centroid), abs=5e-3)


def test_each_part_of_an_assembly_has_its_own(tmp_path):
    backing = replace(part(Plane(1.0)), name="backing")
    write_step(replace(part(), extras=(backing,)), tmp_path / "two.step")
    found = stated_and_measured(tmp_path / "two.step")
    assert [stated["volume"] for stated, *_ in found] == pytest.approx([volume for _, volume, *_ in found])
    assert found[0][1] == pytest.approx(2 * found[1][1])


def test_a_part_that_was_changed_on_the_way_does_not_match(tmp_path):
    """The comparison can fail: the same file with a hole of another radius."""
    write_step(part(), tmp_path / "part.step")
    text = (tmp_path / "part.step").read_text("ascii")
    assert text.count("VOLUME_MEASURE(") == text.count("AREA_MEASURE(") == 1
    (tmp_path / "other.step").write_text(text.replace("VOLUME_MEASURE(4", "VOLUME_MEASURE(5"), "ascii")
    [(stated, volume, *_)] = stated_and_measured(tmp_path / "other.step")
    assert abs(stated["volume"] - volume) > 0.1 * volume


def test_measures_of_a_box_that_lies_far_away():
    from perfqr_cad.geometry import Triangles

    solid = build_profile(Profile((Region(OUTER, ()),)), Plane(2.0))
    moved = Triangles(solid.triangles.vertices + np.array([1e4, 0.0, -5.0]), solid.triangles.faces)
    found = measured(replace(solid, triangles=moved))
    assert found.area_mm2 == pytest.approx(2 * 256 + 4 * 32)
    assert found.centroid_mm == pytest.approx((1e4, 0.0, -4.0), abs=1e-9)
