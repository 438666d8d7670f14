"""The stress field as a file; what is in it is the strength layer's to prove."""

from types import SimpleNamespace

import pytest

import perfqr_cad.structure as structure
from perfqr_cad.errors import DesignError
from perfqr_cad.export import vtu


def test_the_field_of_the_finished_part_is_written(tmp_path, monkeypatch):
    field, path = object(), tmp_path / "part.vtu"
    written = []
    monkeypatch.setattr(structure, "write_vtu", lambda *arguments: written.append(arguments), raising=False)
    vtu.write(SimpleNamespace(stress=field), path)
    assert written == [(field, path)]


def test_a_design_without_a_field_is_refused(tmp_path):
    with pytest.raises(DesignError, match="no stress field"):
        vtu.write(SimpleNamespace(stress=None), tmp_path / "part.vtu")
    assert not list(tmp_path.iterdir())
