"""Triangles: the light region cleaned, cut into tiles, each kind of tile meshed once and joined.

The only package that imports gmsh. Lengths, angles and node numbers; no material, no load, no stiffness.
"""
