"""CalculiX as a second opinion: the same triangles as 15-node wedges (Debian package calculix-ccx).

The program is looked for on the path and never needed: validation and benchmarks use it where it is.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from perfqr_cad.errors import AnalysisError
from perfqr_cad.structure.mesh.triangle import Floats, Ints
from perfqr_cad.structure.shell_model import Model

PROGRAM = "ccx"
TIME_LIMIT_S = 600.0


@dataclass(frozen=True)
class Answer:
    """Displacements (n, 3) in mm, stresses (n, 6) in MPa (xx, yy, zz, xy, yz, zx), nodes (n, 3) in mm."""

    nodes: Floats
    displacement: Floats
    stress: Floats


def installed() -> bool:
    """Whether the program is on the path."""
    return shutil.which(PROGRAM) is not None


def solve(model: Model, pressure_mpa: float) -> Answer:
    """A clamped model under a pressure on its front, as one layer of C3D15.

    Raises:
        AnalysisError: CalculiX is not installed or failed.
    """
    if not installed():
        raise AnalysisError("CalculiX is not installed: apt-get install calculix-ccx")
    nodes, wedges, held = _wedges(model)
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "part.inp"
        _write(deck, nodes, wedges, held, model, pressure_mpa)
        run = subprocess.run(
            [PROGRAM, "-i", "part"],
            cwd=folder,
            env=dict(os.environ, OMP_NUM_THREADS="1"),
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT_S,
            check=False,
        )
        result = deck.with_suffix(".frd")
        if run.returncode or not result.exists():
            raise AnalysisError(f"CalculiX failed: {(run.stdout + run.stderr).strip().splitlines()[-1:]}")
        return Answer(nodes, _field(result, "DISP", 3), _field(result, "STRESS", 6))


def _wedges(model: Model) -> tuple[Floats, Ints, Ints]:
    """Nodes, C3D15 connectivity from 0, and the held nodes: back layer, front layer, verticals."""
    mesh, half = model.mesh, 0.5 * model.wall_mm * model.frames[:, 2]
    count = len(mesh.nodes)
    nodes = np.concatenate([model.positions - half, model.positions + half, model.positions[: mesh.corners]])
    corners, middles = mesh.elements[:, :3], mesh.elements[:, 3:]
    wedges = np.concatenate([corners, corners + count, middles, middles + count, corners + 2 * count], axis=1)
    fixed = np.flatnonzero(model.fixed.reshape(count, -1)[:, 0])
    held = np.concatenate([fixed, fixed + count, fixed[fixed < mesh.corners] + 2 * count])
    return nodes, wedges, held


def _write(path: Path, nodes: Floats, wedges: Ints, held: Ints, model: Model, pressure_mpa: float) -> None:
    with path.open("w") as deck:
        deck.write("*NODE\n")
        np.savetxt(deck, np.c_[np.arange(1, len(nodes) + 1), nodes], fmt="%d,%.9g,%.9g,%.9g")
        deck.write("*ELEMENT, TYPE=C3D15, ELSET=ALL\n")
        rows = np.c_[np.arange(1, len(wedges) + 1), wedges + 1]
        np.savetxt(deck, rows, fmt=",".join(["%d"] * rows.shape[1]))
        deck.write("*NSET, NSET=HELD\n")
        np.savetxt(deck, held + 1, fmt="%d,")
        deck.write(f"*MATERIAL, NAME=M\n*ELASTIC\n{model.material.e_mpa:.9g},{model.material.nu:.9g}\n")
        deck.write("*SOLID SECTION, ELSET=ALL, MATERIAL=M\n*BOUNDARY\nHELD,1,3\n*STEP\n*STATIC\n")
        deck.write(f"*DLOAD\nALL,P2,{pressure_mpa:.9g}\n")  # face 2 of a wedge is its second triangle
        deck.write("*NODE FILE\nU\n*EL FILE\nS\n*END STEP\n")


def _field(path: Path, name: str, components: int) -> Floats:
    """A nodal field of a .frd file, by node number."""
    rows: list[list[float]] = []
    reading = False
    with path.open() as lines:
        for line in lines:
            if line.startswith(" -4"):
                reading = line.split()[1] == name
            elif reading and line.startswith(" -1"):
                rows.append([float(line[13 + 12 * c : 25 + 12 * c]) for c in range(components)])
            elif reading and line.startswith(" -3"):
                break
    return np.array(rows)
