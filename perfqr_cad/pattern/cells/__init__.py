"""The integer lattice on which a pattern is drawn: which cells are solid, their boundaries and corners.

A `Canvas` is a lattice with the bridges painted on it so far; `brightness` is how a reader sees its modules.
Which bridges are painted is decided in `joining`.
"""
