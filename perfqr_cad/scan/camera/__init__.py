"""The simulated camera: scenes of parts, light, lens and sensor; pictures come out.

Nothing here reads a code.
"""
