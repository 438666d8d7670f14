"""Files of a finished part: one format, one module, each with `write(design, path)`.

    write(design, "part.step")           one file, the suffix is the format
    write_outputs(design, ["out/"])      a folder with everything that a maker or an engineer needs

Nothing is ever half-written: files are made in a folder beside their place and renamed into it. An exporter
reads a `DesignView` and computes nothing that a certificate would state.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path, PurePath
from typing import Any

from perfqr_cad.errors import DesignError
from perfqr_cad.export.design_view import DesignView
from perfqr_cad.export.omissions import leaves_out, notes
from perfqr_cad.export.options import DEFAULT, Options
from perfqr_cad.export.staging import check_writable, staged
from perfqr_cad.export.stl import further
from perfqr_cad.progress import tell

# Suffix -> module of this package; loaded on use, since several pull in a heavy library.
FORMATS: dict[str, str] = {
    ".step": "step",
    ".stp": "step",
    ".stl": "stl",
    ".3mf": "threemf",
    ".svg": "svg",
    ".dxf": "dxf",
    ".scad": "scad",
    ".glb": "glb",
    ".png": "picture",
    ".vtu": "vtu",
    ".html": "report",
    ".json": "certificate",
}

# What a folder gets.
FILES: tuple[str, ...] = (
    "part.step",
    "part.stl",
    "part.3mf",
    "part.svg",
    "part.dxf",
    "part.scad",
    "part.png",
    "report.html",
    "design.json",
)


@dataclass(frozen=True)
class FileRecord:
    """A file that was written: its path as asked for, format, size and SHA-256 of its bytes.

    leaves_out  bodies of the design that the file does not hold
    notes       what it shows otherwise than the part is
    """

    path: str
    format: str
    bytes: int
    sha256: str
    leaves_out: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def remarks(self) -> str:
        """Both on one line; empty for a file that holds all as it is."""
        left = f"leaves out {' and '.join(self.leaves_out)}" if self.leaves_out else ""
        return "; ".join(filter(None, (left, *self.notes)))

    def as_dict(self) -> dict[str, Any]:
        """The record as the certificate lists it."""
        return asdict(self)


def check(outputs: Sequence[str | Path]) -> frozenset[str]:
    """Refuse, before any long computation, what `write_outputs` could not write; suffixes of what it will.

    Raises `DesignError` for an unknown suffix, a name that is to be a file and a folder, and a folder or a
    name that cannot be written to.
    """
    targets = _targets(outputs)
    for target in targets:
        module_of(target)
        if taken := next((folder for folder in target.parents if folder in targets), None):
            raise DesignError(f"{taken} cannot be a file and a folder: name one of them otherwise")
        check_writable(target)
    return frozenset(target.suffix.lower() for target in targets)


def write(design: DesignView, path: str | Path, options: Options = DEFAULT) -> FileRecord:
    """Write one file; its suffix is the format. Its folder is made if need be.

    Raises `DesignError` for an unknown suffix and for a folder that cannot be written to.
    """
    module_of(path)
    return _write(design, [Path(path)], options)[0]


def write_outputs(
    design: DesignView, outputs: Sequence[str | Path], options: Options = DEFAULT
) -> tuple[FileRecord, ...]:
    """Write several files and folders; each certificate among them lists all files that are none.

    An output that ends in `/`, has no suffix or is a folder gets `FILES`; folders are made if need be. All
    appear or, after an error, none. Raises `DesignError` as `check` does.
    """
    return _write(design, _targets(outputs), options)


def module_of(path: str | Path) -> str:
    """Name of the module that writes this path. Raises `DesignError` for a suffix that is not known."""
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        known = " ".join(FORMATS)
        raise DesignError(
            f"{Path(path).name}: unknown format {suffix or '(no suffix)'}; use {known}, or FOLDER/ for all"
        )
    return FORMATS[suffix]


def _write(design: DesignView, targets: Sequence[Path], options: Options) -> tuple[FileRecord, ...]:
    modules = {target: module_of(target) for target in targets}
    parts = [target for target in modules if modules[target] != "certificate"]
    certificates = [target for target in modules if modules[target] == "certificate"]
    with ExitStack() as stack:
        folders = dict.fromkeys(target.parent for target in modules)
        stages = {folder: stack.enter_context(staged(folder)) for folder in folders}
        records: list[FileRecord] = []
        for target in parts:
            module = modules[target]
            remarks = {
                "leaves_out": leaves_out(design, module, options),
                "notes": notes(design, module, options),
            }
            written: dict[Path, dict[str, Any]] = {target: {}}
            if module == "stl" and options.split_stl:
                written |= {path: {"body": body} for path, body in further(design, target).items()}
            for path, chosen in written.items():
                if path != target and path in modules:
                    raise DesignError(f"{path} would be written twice: name one of the two otherwise")
                tell(f"writing {path.name}")
                staging = stages[path.parent] / path.name
                import_module(f"{__name__}.{module}").write(design, staging, **options.of(module), **chosen)
                records.append(replace(_record(path, staging), **remarks))
        for target in certificates:
            staging = stages[target.parent] / target.name
            files = [_seen_from(target.parent, record).as_dict() for record in records]
            import_module(f"{__name__}.certificate").write(design, staging, files=files)
            records.append(_record(target, staging))
    return tuple(records)


def _targets(outputs: Sequence[str | Path]) -> list[Path]:
    """Every file to write, once."""
    each = ([Path(o) / name for name in FILES] if _is_folder(o) else [Path(o)] for o in outputs)
    return list(dict.fromkeys(target for targets in each for target in targets))


def _is_folder(output: str | Path) -> bool:
    return str(output).endswith(("/", os.sep)) or not Path(output).suffix or os.path.isdir(output)


def _record(target: Path, written: Path) -> FileRecord:
    data = written.read_bytes()
    kind = target.suffix.lower().removeprefix(".")
    return FileRecord(target.as_posix(), kind, len(data), hashlib.sha256(data).hexdigest())


def _seen_from(folder: Path, record: FileRecord) -> FileRecord:
    """The record with its path as seen from a certificate in `folder`: a design moves with its files."""
    return replace(record, path=PurePath(os.path.relpath(record.path, folder)).as_posix())
