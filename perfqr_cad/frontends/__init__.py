"""Front ends for build123d and CadQuery: thin adapters over one kernel shape, loaded on use.

from perfqr_cad.frontends import PerforatedQR          # a build123d object
import perfqr_cad.frontends.cadquery_plugin            # adds Workplane.perforatedQR
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from perfqr_cad.solid.kernel.convert import shape_of, to_build123d, to_cadquery

if TYPE_CHECKING:
    from perfqr_cad.frontends.build123d_object import PerforatedQR

__all__ = ["PerforatedQR", "shape_of", "to_build123d", "to_cadquery"]


def __getattr__(name: str) -> Any:
    if name == "PerforatedQR":
        return import_module(f"{__name__}.build123d_object").PerforatedQR
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
