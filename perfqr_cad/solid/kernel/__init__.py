"""The solid modeller's room: tables to shapes and back, booleans, evaluation of its curves and surfaces.

Errors of the modeller are translated here. Nothing here knows of patterns or of the files they go to.
"""
