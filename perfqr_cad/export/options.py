"""Choices between variants of a format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, get_args

from perfqr_cad.errors import DesignError
from perfqr_cad.export.dxf import DxfVersion
from perfqr_cad.export.svg import SvgVariant


@dataclass(frozen=True)
class Options:
    """How files are written. Raises `DesignError` for a variant that there is not.

    dxf          r2000, or r12 for old programs
    dxf_bridges  whether bridges are drawn on a frozen layer of their own
    svg          filled, or cut: hairlines in the colours of what a cutter does along them
    kerf_mm      width that the cutter takes away, of which paths keep half off the part
    split_stl    whether each further body, a backing say, gets an STL file of its own
    colour_change  whether 3MF files change the colour between layers, for one nozzle, instead of the tool
    """

    dxf: DxfVersion = "r2000"
    dxf_bridges: bool = False
    svg: SvgVariant = "filled"
    kerf_mm: float = 0.0
    colour_change: bool = False
    split_stl: bool = False

    def __post_init__(self) -> None:
        for name, value, known in (
            ("dxf", self.dxf, get_args(DxfVersion)),
            ("svg", self.svg, get_args(SvgVariant)),
        ):
            if value not in known:
                raise DesignError(f"{name}={value!r} is no variant of that format: use {' or '.join(known)}")

    def of(self, module: str) -> dict[str, Any]:
        """Keyword arguments of a format's `write`."""
        match module:
            case "dxf":
                return {"version": self.dxf, "bridges": self.dxf_bridges, "kerf_mm": self.kerf_mm}
            case "svg":
                return {"variant": self.svg, "kerf_mm": self.kerf_mm}
            case "threemf":
                return {"colour_change": self.colour_change}
            case _:
                return {}


DEFAULT = Options()
