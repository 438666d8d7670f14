"""Bridges for strength: Algorithm 1, the choices of bridges it offers, and their quick re-analysis.

Reads patterns and returns new ones. Meshes and matrices are asked for through `analysis`, never built here.
"""
