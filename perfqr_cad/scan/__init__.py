"""The simulated camera and the panel of decoders: proof that a part scans, before it is made."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .look import BLACK, WHITE, Light, Look, Optics
from .report import DecoderResult, ScanReport, Sight

if TYPE_CHECKING:
    from .camera import Camera, Target, View
    from .drawn import drawn
    from .filed import part
    from .flat import FlatPrint, printed
    from .panel import Panel
    from .placing import Part, load_mesh, place
    from .proof import FULL, QUICK, Plan, certify, reads
    from .scene import Scene
    from .search import Goal, Trial, improve
    from .surrogate import Legibility, legibility

_MODULES = {
    "camera": ("Camera", "Target", "View"),
    "drawn": ("drawn",),
    "filed": ("part",),
    "flat": ("FlatPrint", "printed"),
    "panel": ("Panel",),
    "placing": ("Part", "load_mesh", "place"),
    "proof": ("FULL", "QUICK", "Plan", "certify", "reads"),
    "scene": ("Scene",),
    "search": ("Goal", "Trial", "improve"),
    "surrogate": ("Legibility", "legibility"),
}
# Loaded when first asked for: they import OpenCV.
_LAZY = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "BLACK", "FULL", "QUICK", "WHITE", "Camera", "DecoderResult", "FlatPrint", "Goal", "Legibility", "Light",
    "Look", "Optics", "Panel", "Part", "Plan", "ScanReport", "Scene", "Sight", "Target", "Trial", "View",
    "certify", "drawn", "improve", "legibility", "load_mesh", "part", "place", "printed", "reads",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_LAZY[name]}"), name)
    globals()[name] = value
    return value
