"""Loads of a hand: their names and newtons, where each presses and holds, what a part bears of it and where.

Solves on models that others made. No mesh, no element matrix, no bridge: those are the neighbours' business.
"""
