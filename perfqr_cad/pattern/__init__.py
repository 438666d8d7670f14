"""The 2-D design in millimetres: outlines, islands, bridges."""

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.compose import build
from perfqr_cad.pattern.pattern import Optimality, Pattern
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.pattern.surround import Hole, Surround

__all__ = ["Bridge", "Hole", "Optimality", "Pattern", "PatternSpec", "Surround", "build"]
