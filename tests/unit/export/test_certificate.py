from __future__ import annotations

import json
from dataclasses import replace

import numpy as np

from perfqr_cad.export import certificate


def test_values_become_json(plate, tmp_path):
    facts = {"loss": np.float64("inf"), "n": np.int64(3), "box": np.eye(2), "text": "grün", "ok": np.True_}
    certificate.write(replace(plate, facts=facts), tmp_path / "c.json")
    text = (tmp_path / "c.json").read_text("utf-8")
    assert json.loads(text) == {"loss": None, "n": 3, "box": [[1, 0], [0, 1]], "text": "grün", "ok": True}
    assert text.endswith("}\n")


def test_the_design_keeps_its_own_files_unless_given_others(plate, tmp_path):
    design = replace(plate, facts={"files": [{"path": "a"}]})
    certificate.write(design, tmp_path / "own.json")
    certificate.write(design, tmp_path / "given.json", files=[])
    assert json.loads((tmp_path / "own.json").read_text())["files"] == [{"path": "a"}]
    assert json.loads((tmp_path / "given.json").read_text())["files"] == []
