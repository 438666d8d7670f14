"""`perfqr scan PART`: a written part goes before the camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from perfqr_cad.bounded import MIB, read_json
from perfqr_cad.errors import DesignError
from perfqr_cad.geometry import Triangles
from perfqr_cad.scan.camera.placing import load_mesh
from perfqr_cad.scan.decoding.decoders import accepted
from perfqr_cad.scan.decoding.panel import shared
from perfqr_cad.scan.facing import BACKING_NOTE, turned
from perfqr_cad.scan.proof import certify
from perfqr_cad.scan.report import ScanReport
from perfqr_cad.scan.schedule import FULL, Schedule
from perfqr_cad.surface import Placement

MESHES = (".stl", ".3mf", ".ply", ".obj", ".off")
STEPS = (".step", ".stp")
MOST_BYTES = 16 * MIB  # of a certificate; that of a version-40 part has 2 MB
GUESSED_NOTE = (
    "no decoder reads the file with all bodies in one colour: what lies behind the plate was taken to be of "
    "the ground's colour; scan the design.json, which knows"
)
# Of the files beside a design.json, the first of these that exists is filmed.
PREFERRED = (".stl", ".3mf", ".step", ".stp")


def part(
    path: str | Path,
    text: str | None = None,
    *,
    mesh_step: Callable[[Path], Triangles] | None = None,
    placement: Placement | None = None,
    schedule: Schedule = FULL,
    decoders: tuple[str, ...] | None = None,
    seed: int = 0,
) -> ScanReport:
    """Film a written part: .stl, .3mf, .step, or a design.json with the files that it names.

    text        what must come back; None: what the design.json says, or what the decoders agree on
    mesh_step   triangles of a STEP file; the solid modeller is not ours to call
    placement   where the code lies; None: on the top of a plate, else on the side from which it is read

    KernelError if the file cannot be read, DesignError if it is no kind of part.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    backed = False
    if suffix == ".json":
        path, said, backed = _of_design(path)
        suffix, text = path.suffix.lower(), said if text is None else text
    if suffix in MESHES:
        triangles = load_mesh(path)
    elif suffix in STEPS and mesh_step is not None:
        triangles = mesh_step(path)
    else:
        raise DesignError(f"{path.name} is no part: give an .stl, .3mf or .step file, or a design.json")
    if placement is not None:
        return certify(triangles, placement, None, text, schedule=schedule, decoders=decoders, seed=seed)

    def filmed(backed: bool) -> ScanReport:
        right = None if text is None else accepted(text)
        seen, behind, notes = turned(triangles, shared(decoders), right, backed=backed)
        report = certify(
            seen, None, None, text, schedule=schedule, decoders=decoders, seed=seed, behind=behind
        )
        return replace(report, warnings=(*report.warnings, *notes))

    report = filmed(backed)
    if backed or report.readers or triangles.body_count == 1:
        return report
    # Bodies of one colour show nothing: what lies behind the plate may be its ground, as a backing is.
    report = filmed(True)
    notes = (GUESSED_NOTE if note == BACKING_NOTE else note for note in report.warnings)
    return replace(report, warnings=tuple(notes))


def _of_design(path: Path) -> tuple[Path, str | None, bool]:
    """The file to film, the payload and whether there is a backing, from a certificate."""
    certificate = read_json(path, MOST_BYTES, DesignError, "a design.json")
    try:
        names = [Path(record["path"]) for record in certificate["files"]]
        payload = certificate["payload"]
        backed = (certificate.get("request") or {}).get("backing_mm") is not None
    except (AttributeError, KeyError, TypeError) as error:
        raise DesignError(f"{path} is no certificate of a design ({error}): give a design.json") from error
    if not isinstance(payload, str | None):
        raise DesignError(f"{path} has a payload that is no text: give a design.json")
    written = [path.parent / name.name for name in names] + names
    for suffix in PREFERRED:
        for candidate in written:
            if candidate.suffix.lower() == suffix and candidate.is_file():
                return candidate, payload, backed
    raise DesignError(f"{path} names no .stl, .3mf or .step file that exists: write one beside it")
