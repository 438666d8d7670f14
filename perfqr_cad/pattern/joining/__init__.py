"""How many pieces become one: rings of finder patterns, routes between islands, the choice among them.

Cells in, bridges out; outlines are drawn elsewhere.
"""
