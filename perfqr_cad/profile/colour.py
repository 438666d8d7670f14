"""sRGB colours of parts as files show them."""

from __future__ import annotations

Colour = tuple[float, float, float]

LIGHT: Colour = (0.92, 0.92, 0.90)  # the part itself
DARK: Colour = (0.05, 0.05, 0.06)  # what lies behind it, in the tone of the holes
