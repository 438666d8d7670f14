"""What every module of a QR code means (ISO/IEC 18004): tables, layout, encoding, correction, readability.

Text, codewords and modules only: nothing here knows of pictures, millimetres or material.
"""

from perfqr_cad.symbol.drawing import Symbol, deinterleave, draw, extract
from perfqr_cad.symbol.encoding import encode, free_codewords, interleave, padded, with_best_mask, with_pads
from perfqr_cad.symbol.format import FormatInfo, format_candidates, format_word, read_format, read_version
from perfqr_cad.symbol.freedom import Freedom, Wishes, freedom
from perfqr_cad.symbol.layout import Layout, Role, layout
from perfqr_cad.symbol.masks import mask_pattern, penalty
from perfqr_cad.symbol.matrix import Matrix
from perfqr_cad.symbol.payload import Payload, Segment, StructuredAppend, payload_of
from perfqr_cad.symbol.readability import Readability, ReadabilityTracker, readability
from perfqr_cad.symbol.recovery import Recovery, recover
from perfqr_cad.symbol.tables import LEVELS, QUIET_MODULES, Blocks, Level, blocks, size_of, version_of

__all__ = [
    "LEVELS",
    "QUIET_MODULES",
    "Blocks",
    "FormatInfo",
    "Freedom",
    "Layout",
    "Level",
    "Matrix",
    "Payload",
    "Readability",
    "ReadabilityTracker",
    "Recovery",
    "Role",
    "Segment",
    "StructuredAppend",
    "Symbol",
    "Wishes",
    "blocks",
    "deinterleave",
    "draw",
    "encode",
    "extract",
    "format_candidates",
    "format_word",
    "free_codewords",
    "freedom",
    "interleave",
    "layout",
    "mask_pattern",
    "padded",
    "payload_of",
    "penalty",
    "read_format",
    "read_version",
    "readability",
    "recover",
    "size_of",
    "version_of",
    "with_best_mask",
    "with_pads",
]
