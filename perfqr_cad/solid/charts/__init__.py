"""Charts: segments and walls of the pattern on one kind of placement, as exact or fitted geometry.

One module per kind of surface, and what several share. Topology is made in `stitch`, never here.
"""
