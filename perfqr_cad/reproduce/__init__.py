"""The paper's tables and figures, one module each: `run(out)` writes pictures and returns a table.

Nothing here is imported by the program. Where the paper's pictures cannot be shipped, stand-ins take their
place.
"""
