"""From a canvas to an outline in mm: sizes, styles, fillets, and the proof that webs hold.

Which pieces are joined, and how, is decided in `joining`; what the pattern then is, in `pattern.pattern`.
"""
