"""From cells and bridges to an outline in mm: sizes, styles, fillets, the surround, and the proof of webs.

Which pieces are joined, and how, is decided in `joining`.
"""
