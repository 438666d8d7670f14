"""From a matrix with errors, Q, to the correct symbol, Q₀ (paper §4.2): codewords are corrected in place.

The text is never encoded again: another encoder might have chosen other segments, pads or mask.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.correction import FloatArray, correct_erased, nearest
from perfqr_cad.symbol.drawing import Symbol, extract
from perfqr_cad.symbol.format import FormatInfo, format_candidates
from perfqr_cad.symbol.galois import ByteArray, syndromes
from perfqr_cad.symbol.layout import Layout, layout
from perfqr_cad.symbol.masks import mask_pattern
from perfqr_cad.symbol.matrix import Matrix
from perfqr_cad.symbol.payload import Payload, payload_of
from perfqr_cad.symbol.tables import Blocks

_BLOCKS_NAMED: Final = 8  # in a message


@dataclass(frozen=True)
class Recovery:
    """A matrix and the symbol it stands for.

    errors    codewords of each block in which Q differs from Q₀
    capacity  r of each block (Table 9)
    erasures  codewords of each block that were given up as unreliable before decoding; 0 where plain
              decoding did. Such a block may have more errors than its capacity: the picture could be
              read by its shades, yet L(Q) of its hard decisions is inf, as Eq. (2) has it.
    """

    observed: Matrix
    symbol: Symbol
    errors: tuple[int, ...]
    capacity: tuple[int, ...]
    erasures: tuple[int, ...]
    payload: Payload


def recover(observed: Matrix, *, log_likelihood: FloatArray | None = None) -> Recovery:
    """The symbol nearest to a matrix.

    log_likelihood  (n, n), ln(P(dark)/P(light)) of each module; with it the least certain codewords are
                    tried as erasures where a block has more than r errors. One erasure costs half of
                    what an error does, so up to twice the damage is repaired.

    Every format within reach of its BCH code is tried, likeliest first. SymbolError names the blocks that
    have too many errors and the number that they can bear.

    >>> from perfqr_cad.symbol import encode
    >>> symbol = encode("HELLO", level="H")
    >>> found = recover(symbol.matrix.flipped([(20, 20), (9, 9)]))
    >>> found.symbol == symbol, found.errors, found.payload.text
    (True, (2,), 'HELLO')
    """
    if log_likelihood is not None and log_likelihood.shape != observed.dark.shape:
        raise SymbolError(
            f"log-likelihoods of shape {log_likelihood.shape} for a matrix of {observed.dark.shape}:"
            " give one for each module"
        )
    if log_likelihood is not None and np.isnan(log_likelihood).any():
        raise SymbolError("a log-likelihood is not a number: use 0 for a module of which nothing is known")
    failures: list[SymbolError] = []
    for info in format_candidates(observed, log_likelihood):
        try:
            return _recover_as(info, observed, log_likelihood)
        except SymbolError as failure:
            failures.append(failure)
    raise failures[0]


def _recover_as(info: FormatInfo, observed: Matrix, log_likelihood: FloatArray | None) -> Recovery:
    """Recovery under one reading of the format information."""
    at = layout(observed.version, info.level)
    placed = np.frombuffer(extract(observed, info.level, info.mask), np.uint8)
    corrected = placed.copy()
    erasures = [0] * at.blocks.count
    failed = _correct_errors(corrected, at)
    if failed and log_likelihood is None:
        raise SymbolError(_beyond(failed, at.blocks, info))
    if failed and log_likelihood is not None:
        shades = _shades(at, info.mask, log_likelihood)
        for block in failed:
            members = at.codewords_of_block(block)
            found = correct_erased(placed[members], shades[members], at.blocks.ec)
            if found is None:
                raise SymbolError(_beyond(failed, at.blocks, info))
            corrected[members], erasures[block] = found
    symbol = Symbol(observed.version, info.level, info.mask, corrected.tobytes())
    errors = np.bincount(at.block_of_codeword[placed != corrected], minlength=at.blocks.count)
    return Recovery(
        observed=observed,
        symbol=symbol,
        errors=tuple(errors.tolist()),
        capacity=(at.blocks.capacity,) * at.blocks.count,
        erasures=tuple(erasures),
        payload=payload_of(symbol),
    )


def _correct_errors(placed: ByteArray, at: Layout) -> list[int]:
    """Corrects blocks with up to r errors in place; returns the numbers of the others."""
    failed: list[int] = []
    for group, first in zip(at.groups, (0, len(at.groups[0])), strict=False):
        checks = syndromes(placed[group], at.blocks.ec)
        for row in np.flatnonzero(checks.any(axis=1)).tolist():
            word = placed[group[row]]
            found = nearest(word, checks[row], [])
            if found is None or np.count_nonzero(found != word) > at.blocks.capacity:
                failed.append(first + row)
            else:
                placed[group[row]] = found
    return failed


def _shades(at: Layout, mask: int, log_likelihood: FloatArray) -> FloatArray:
    """(C, 8) log-likelihoods of a 1 in each bit of the codewords, the mask taken off."""
    places = at.modules[..., 0], at.modules[..., 1]
    return log_likelihood[places] * np.where(mask_pattern(at.version, mask)[places], -1.0, 1.0)


def _beyond(failed: list[int], structure: Blocks, info: FormatInfo) -> str:
    names = ", ".join(str(block + 1) for block in failed[:_BLOCKS_NAMED])
    names += ", …" if len(failed) > _BLOCKS_NAMED else ""
    return (
        f"damaged beyond repair: {len(failed)} of {structure.count} blocks ({names}) have more than"
        f" {structure.capacity} wrong codewords, a block of level {info.level} can bear {structure.capacity}:"
        " restore the modules or take a clearer picture"
    )
