"""The 2-D design in millimetres: outlines, islands, bridges.

Symbol and art come in, one `Pattern` goes out: painted in `cells`, made one piece in `joining`, outlined in
`drawing`. Nothing here knows where the code will lie, nor of thickness but the height of a recessed bar.
"""

from perfqr_cad.pattern.bridge import Bridge
from perfqr_cad.pattern.compose import build
from perfqr_cad.pattern.joining.spanning import Optimality
from perfqr_cad.pattern.pattern import Pattern
from perfqr_cad.pattern.spec import PatternSpec
from perfqr_cad.pattern.surround import Hole, Surround

__all__ = ["Bridge", "Hole", "Optimality", "Pattern", "PatternSpec", "Surround", "build"]
