"""How a verifier would grade the part: ISO/IEC 15415 and ISO/IEC 29158 on the filmed solid.

`verifier` films the part as a verifier does and measures modules; `scale` turns a figure into a grade,
`fixed` grades what is drawn in every symbol, `standards` puts the parameters of each standard together, and
`verdict` says which ground counts. No decoder is asked, and nothing here is a verifier: the light is
simulated.
"""

from perfqr_cad.scan.grade.scale import LETTERS, letter
from perfqr_cad.scan.grade.standards import Grade, dpm, print_quality
from perfqr_cad.scan.grade.verdict import SymbolGrade, graded

__all__ = ["LETTERS", "Grade", "SymbolGrade", "dpm", "graded", "letter", "print_quality"]
