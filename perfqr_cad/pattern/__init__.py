"""The 2-D design in millimetres: outlines, islands, bridges."""

from .outline import Arc, Bezier, Circle, Line, Loop, Region
from .pattern import Bridge, Optimality, Pattern
from .spec import PatternSpec

__all__ = [
    "Arc",
    "Bezier",
    "Bridge",
    "Circle",
    "Line",
    "Loop",
    "Optimality",
    "Pattern",
    "PatternSpec",
    "Region",
]
