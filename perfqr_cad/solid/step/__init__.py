"""STEP, AP242: a writer in linear time for our own tables, and the modeller's reader.

One module per section of the file. What is written was proven before; nothing is healed or checked here.
"""
