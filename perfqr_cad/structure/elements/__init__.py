"""Stiffness: element matrices of plate, shell and wedge, their assembly, condensed tiles, direct solvers.

Linear elasticity on given meshes. No pattern, no load case, no limits: nothing here knows what a code is.
"""
