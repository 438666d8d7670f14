"""How many pieces become one: rings of finder patterns, routes between islands, the choice among them.

A canvas comes in and goes out with more bridges; outlines are drawn elsewhere.
"""
