"""What a code is carved into when it is a part of your own: find the place, measure the wall, carve.

Here: what STEP solids and triangle meshes share. `step/` and `mesh/` hold the two kinds of host.
"""
