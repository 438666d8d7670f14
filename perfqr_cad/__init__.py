"""perfqr-cad: perforated QR codes as parts that can be printed, cut or opened in a CAD suite.

from perfqr_cad import make
make(text="https://example.com/p/1", size_mm=60).write("part.step")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from perfqr_cad.errors import (
    AnalysisError,
    CaptureError,
    DesignError,
    KernelError,
    PerfQRError,
    SymbolError,
    TemplateError,
)

if TYPE_CHECKING:
    from perfqr_cad.capture import read
    from perfqr_cad.catalog.settings import settings
    from perfqr_cad.frontends import PerforatedQR
    from perfqr_cad.pipeline.chain import make
    from perfqr_cad.pipeline.design import Design
    from perfqr_cad.pipeline.request import Request

__version__ = "0.1.0"

__all__ = [
    "AnalysisError",
    "CaptureError",
    "Design",
    "DesignError",
    "KernelError",
    "PerfQRError",
    "PerforatedQR",
    "Request",
    "SymbolError",
    "TemplateError",
    "make",
    "read",
    "settings",
]

# Names that pull in numerical libraries are loaded on first use, so that importing the package is instant.
_LAZY = {
    "Design": "perfqr_cad.pipeline.design",
    "PerforatedQR": "perfqr_cad.frontends",
    "Request": "perfqr_cad.pipeline.request",
    "make": "perfqr_cad.pipeline.chain",
    "read": "perfqr_cad.capture",
    "settings": "perfqr_cad.catalog.settings",
}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(_LAZY[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
