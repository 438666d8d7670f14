"""A flat plate with a perforated code."""

from perfqr_cad import make, settings

# [Shared: Code, Look, Body, Walls, Strength, Proof, Files]


def build(p):
    return make(**settings(p))
