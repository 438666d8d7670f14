"""The simulated camera and the panel of decoders: proof that a part scans, before it is made.

Triangles or a pattern come in, a `ScanReport` goes out: `camera` makes pictures, `decoding` reads them, the
modules here decide what is filmed and what it proves. Nothing here builds or changes a part.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from perfqr_cad.scan.camera.look import BLACK, WHITE, Light, Look, Optics
from perfqr_cad.scan.report import DecoderResult, FilmedView, ScanReport

if TYPE_CHECKING:
    from perfqr_cad.scan.camera.camera import Camera, CodeFrame, View
    from perfqr_cad.scan.camera.flat import FlatPrint, printed
    from perfqr_cad.scan.camera.placing import FilmedPart, load_mesh, place
    from perfqr_cad.scan.camera.preview import plate_scene
    from perfqr_cad.scan.camera.scene import Scene
    from perfqr_cad.scan.decoding.panel import Panel
    from perfqr_cad.scan.filed import part
    from perfqr_cad.scan.filming import reads
    from perfqr_cad.scan.grounds import GROUNDS, Ground
    from perfqr_cad.scan.proof import certify
    from perfqr_cad.scan.schedule import FULL, QUICK, Schedule
    from perfqr_cad.scan.search import Goal, Trial, improve
    from perfqr_cad.scan.surrogate import Legibility, legibility

_MODULES = {
    "camera.camera": ("Camera", "CodeFrame", "View"),
    "camera.flat": ("FlatPrint", "printed"),
    "camera.placing": ("FilmedPart", "load_mesh", "place"),
    "camera.scene": ("Scene",),
    "camera.preview": ("plate_scene",),
    "decoding.panel": ("Panel",),
    "filed": ("part",),
    "filming": ("reads",),
    "grounds": ("GROUNDS", "Ground"),
    "proof": ("certify",),
    "schedule": ("FULL", "QUICK", "Schedule"),
    "search": ("Goal", "Trial", "improve"),
    "surrogate": ("Legibility", "legibility"),
}
# Loaded when first asked for: they import OpenCV.
_LAZY = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "BLACK",
    "FULL",
    "GROUNDS",
    "QUICK",
    "WHITE",
    "Camera",
    "CodeFrame",
    "DecoderResult",
    "FilmedPart",
    "FilmedView",
    "FlatPrint",
    "Goal",
    "Ground",
    "Legibility",
    "Light",
    "Look",
    "Optics",
    "Panel",
    "ScanReport",
    "Scene",
    "Schedule",
    "Trial",
    "View",
    "certify",
    "improve",
    "legibility",
    "load_mesh",
    "part",
    "place",
    "plate_scene",
    "printed",
    "reads",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_LAZY[name]}"), name)
    globals()[name] = value
    return value
