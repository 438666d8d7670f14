from pathlib import Path

import pytest
from matplotlib.figure import Figure
from shapely.geometry import box

from perfqr_cad.pattern import Bridge
from perfqr_cad.structure import Case, Part, Pressure, analyse_part
from perfqr_cad.structure.mesh.seeding import MeshSize
from perfqr_cad.structure.stress_maps import draw
from perfqr_cad.surface import Plane

FIELD = analyse_part(Part(box(-5, -5, 5, 5), Plane(1.0)), Case.of(Pressure(1e-3)), MeshSize.graded(2.0, 0.4))


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
