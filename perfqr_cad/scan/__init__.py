"""The simulated camera and the panel of decoders: proof that a part scans, before it is made."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .look import BLACK, WHITE, Light, Look, Optics
from .report import DecoderResult, ScanReport, Sight

if TYPE_CHECKING:
    from .camera import Camera, Target, View
    from .certify import certify
    from .panel import Panel
    from .part import Part, load_mesh, place
    from .scene import Scene

# Loaded when first asked for: they import OpenCV.
_LAZY = {
    "Camera": "camera", "Target": "camera", "View": "camera", "certify": "certify", "Panel": "panel",
    "Part": "part", "load_mesh": "part", "place": "part", "Scene": "scene",
}  # fmt: skip

__all__ = [
    "BLACK", "WHITE", "Camera", "DecoderResult", "Light", "Look", "Optics", "Panel", "Part", "ScanReport",
    "Scene", "Sight", "Target", "View", "certify", "load_mesh", "place",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_LAZY[name]}"), name)
    globals()[name] = value
    return value
