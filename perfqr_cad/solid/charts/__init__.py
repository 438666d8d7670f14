"""How the pattern plane lies in a wall: segments and walls of one placement as exact or fitted geometry.

One chart per kind of surface; topology is made in `stitch`.
"""
