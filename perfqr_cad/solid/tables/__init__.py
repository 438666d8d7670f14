"""A boundary as tables: vertices, edges, loops and faces as arrays, geometry in batches of one kind.

Plain arrays; no modeller, no patterns.
"""
