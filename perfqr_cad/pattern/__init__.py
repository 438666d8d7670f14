"""The 2-D design in millimetres: outlines, islands, bridges."""

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.drafting import build
from perfqr_cad.pattern.outline import Arc, Bezier, Circle, Line, Loop, Region
from perfqr_cad.pattern.pattern import Optimality, Pattern
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.pattern.surround import Hole, Surround

__all__ = [
    "Arc",
    "Bezier",
    "Bridge",
    "Circle",
    "Hole",
    "Line",
    "Loop",
    "Optimality",
    "Pattern",
    "PatternSpec",
    "Region",
    "Surround",
    "build",
]
