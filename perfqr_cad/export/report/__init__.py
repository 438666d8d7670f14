"""The HTML report: the page, the pieces of markup it is made of, its style sheet, and the curve of L(Q).

All that it shows comes from the design and its certificate: nothing is computed here that they do not say.
"""

from perfqr_cad.export.report.page import write

__all__ = ["write"]
