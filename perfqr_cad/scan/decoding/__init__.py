"""The readers: one function per engine, and the panel that runs them in processes of their own.

Pictures in, payloads out; nothing here knows of parts or cameras.
"""
