"""Geometry that two layers need: outlines in the plane, their offsets and triangles, splines, closed meshes.

Plain arrays and values in mm; nothing here knows of codes, walls of material or the solid modeller.
"""

from perfqr_cad.geometry.outline import Arc, Bezier, Circle, Line, Loop, Region
from perfqr_cad.geometry.triangles import Triangles

__all__ = ["Arc", "Bezier", "Circle", "Line", "Loop", "Region", "Triangles"]
