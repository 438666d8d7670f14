"""What a code is carved into when it is a part of your own: find the place, survey the wall, carve.

Here: what STEP solids and triangle meshes share; `step/` and `mesh/` hold what is peculiar to one of them.
Exact geometry itself belongs to `solid/`, strength and scanning know of no host.
"""
