"""Pictures as arrays: files of every kind opened within limits, and the grey views of them.

Nothing here knows of codes; foreign formats are decoded in processes of their own.
"""
