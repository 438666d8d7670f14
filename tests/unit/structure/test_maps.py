from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from shapely.geometry import box

from perfqr_cad.pattern import Bridge
from perfqr_cad.structure import Pressure, analyse_region
from perfqr_cad.structure.maps import draw
from perfqr_cad.surface import Plane

FIELD = analyse_region(box(-5, -5, 5, 5), Plane(1.0), load=Pressure(1e-3), mesh_size_mm=2.0)


@pytest.mark.parametrize("what", ["stress", "deflection"])
def test_file_is_a_png_and_the_same_twice(tmp_path: Path, what: str) -> None:
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    draw(FIELD, one, what)  # type: ignore[arg-type]
    draw(FIELD, two, what)  # type: ignore[arg-type]
    assert one.read_bytes().startswith(b"\x89PNG")
    assert one.read_bytes() == two.read_bytes()


def test_axes_show_largest_value_and_bridges() -> None:
    axes = Figure().subplots()
    draw(FIELD, axes, "stress", bridges=[Bridge((0, 0), (2, 0), 0.8, "structural", 0.0)], limit=1.0)
    assert f"{FIELD.max_stress_mpa:.3g}" in axes.get_title()
    outline = axes.patches[0].get_path().vertices
    assert (outline[:, 0].min(), outline[:, 1].max()) == pytest.approx((0.0, 0.4))


def test_vtu_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    from xml.etree import ElementTree

    from perfqr_cad.structure import write_vtu

    write_vtu(FIELD, tmp_path / "field.vtu")
    root = ElementTree.parse(tmp_path / "field.vtu").getroot()
    arrays = {a.get("Name"): np.array((a.text or "").split(), float) for a in root.iter("DataArray")}
    assert arrays["points"].reshape(-1, 3) == pytest.approx(FIELD.nodes_mm, abs=1e-7)
    assert (arrays["connectivity"].reshape(-1, 6) == FIELD.mesh.elements).all()
    assert arrays["offsets"][-1] == len(arrays["connectivity"])
    assert set(arrays["types"]) == {22}
    assert arrays["von_mises_mpa"] == pytest.approx(FIELD.von_mises_mpa, rel=1e-6)
    assert arrays["displacement_mm"].reshape(-1, 3) == pytest.approx(FIELD.displacement_mm, abs=1e-9)
