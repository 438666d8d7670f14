"""A boundary as tables: vertices, edges, loops and faces as arrays, geometry in batches of one kind.

Plain arrays and their evaluation. No modeller, no patterns, no files.
"""
