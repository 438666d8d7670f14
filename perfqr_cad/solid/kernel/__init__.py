"""The solid modeller's room: tables to shapes and back, booleans, evaluation of its curves and surfaces.

Errors of the modeller are translated here.
"""
