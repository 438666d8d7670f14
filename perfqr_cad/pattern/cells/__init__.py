"""The integer lattice on which a pattern is drawn: which cells are solid, their boundaries and corners.

Nothing here knows of bridges or of millimetres.
"""
