"""The bytes of the text formats, so that no change of format goes unseen (script: export_files.py)."""

import runpy
from pathlib import Path

import pytest

SCRIPT = runpy.run_path(str(Path(__file__).with_name("export_files.py")))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("golden")
    SCRIPT["write"](folder)
    return folder


@pytest.mark.parametrize("name", SCRIPT["NAMES"])
def test_same_bytes_as_ever(written, name):
    assert (written / name).read_bytes() == (SCRIPT["GOLDEN"] / name).read_bytes()
