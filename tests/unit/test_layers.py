"""The layers of ARCHITECTURE.md, held by import-linter."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
BROKEN = """
[importlinter]
root_package = perfqr_cad
include_external_packages = True

[importlinter:contract:upside-down]
name = symbol must not need numpy
type = forbidden
source_modules = perfqr_cad.symbol
forbidden_modules = numpy
"""


def lint(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = Path(sys.executable).parent / "lint-imports"
    return subprocess.run(
        [command, "--no-cache", *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    )


def test_data_flows_one_way() -> None:
    result = lint()
    assert result.returncode == 0, result.stdout


def test_a_broken_contract_is_noticed(tmp_path: Path) -> None:
    config = tmp_path / "broken.ini"
    config.write_text(BROKEN)
    assert lint("--config", str(config)).returncode == 1
