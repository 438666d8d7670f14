"""From a matrix with errors, Q, to the correct symbol, Q₀ (paper §4.2): codewords are corrected in place.

The text is never encoded again: another encoder might have chosen other segments, pads or mask.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import comb
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.drawing import Symbol, extract
from perfqr_cad.symbol.format import FormatInfo, format_candidates
from perfqr_cad.symbol.galois import PRIMITIVE, ByteArray, valid
from perfqr_cad.symbol.layout import Layout, layout
from perfqr_cad.symbol.matrix import Matrix
from perfqr_cad.symbol.payload import Payload, payload_of
from perfqr_cad.symbol.tables import Blocks

FloatArray = NDArray[np.floating]

# Chance that random codewords pass as correctable. Without erasures the least protected symbol of Table 9,
# 2-L with r = 4, comes to 5e-10; erasures may not make it worse than this.
MISDECODE_LIMIT: Final = 1e-9

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
    """
    if log_likelihood is not None and log_likelihood.shape != observed.dark.shape:
        raise SymbolError(
            f"log-likelihoods of shape {log_likelihood.shape} for a matrix of {observed.dark.shape}:"
            " give one for each module"
        )
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
        doubt = _doubt(at, log_likelihood)
        for block in failed:
            members = at.codewords_of_block(block)
            order: list[int] = np.argsort(-doubt[members], kind="stable").tolist()
            found = _correct_erased(placed[members], at.blocks, order)
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
        for row in np.flatnonzero(~valid(placed[group], at.blocks.ec)).tolist():
            found = _decode(placed[group[row]], at.blocks, [])
            if found is None:
                failed.append(first + row)
            else:
                placed[group[row]] = found
    return failed


def _correct_erased(word: ByteArray, structure: Blocks, order: list[int]) -> tuple[ByteArray, int] | None:
    """A block corrected after erasing its 2, 4, … most doubtful codewords, and their number; or None.

    Forney's generalised minimum distance decoding: the smallest set that gives a trustworthy word wins.
    """
    for erased in range(2, structure.ec, 2):
        found = _decode(word, structure, order[:erased])
        if found is not None:
            return found, erased
    return None


def _decode(word: ByteArray, structure: Blocks, erased: list[int]) -> ByteArray | None:
    """The valid word nearest to this one, or None when there is none that can be trusted."""
    reedsolo = _reedsolo()
    try:
        data, check, _ = reedsolo.rs_correct_msg(bytearray(word.tobytes()), structure.ec, erase_pos=erased)
    except reedsolo.ReedSolomonError:
        return None
    found = np.frombuffer(bytes(data + check), np.uint8)
    errors = int(np.count_nonzero(np.delete(found != word, erased)))
    chance = misdecode_chance(len(word), structure.ec, len(erased), errors)
    trusted = errors <= structure.capacity and chance <= MISDECODE_LIMIT
    return found if trusted and bool(valid(found[None], structure.ec)[0]) else None


@cache
def _reedsolo() -> Any:
    """reedsolo with the tables of this field."""
    import reedsolo

    reedsolo.init_tables(prim=PRIMITIVE)
    return reedsolo


def _doubt(at: Layout, log_likelihood: FloatArray) -> FloatArray:
    """(C,) expected wrong bits of each codeword: Σ P(module misread) = Σ 1/(1 + e^|ℓ|)."""
    certainty = np.abs(log_likelihood[at.modules[..., 0], at.modules[..., 1]])
    return np.sum(np.exp(-np.logaddexp(0.0, certainty)), axis=1)


def _beyond(failed: list[int], structure: Blocks, info: FormatInfo) -> str:
    names = ", ".join(str(block + 1) for block in failed[:_BLOCKS_NAMED])
    names += ", …" if len(failed) > _BLOCKS_NAMED else ""
    return (
        f"damaged beyond repair: {len(failed)} of {structure.count} blocks ({names}) have more than"
        f" {structure.capacity} wrong codewords, a block of level {info.level} can bear {structure.capacity}:"
        " restore the modules or take a clearer picture"
    )


def misdecode_chance(length: int, ec: int, erased: int, errors: int) -> float:
    """Bound on the chance that `length` random codewords decode with these erasures and that many errors.

    There are C(length − erased, errors)·255^errors words within reach of each valid one, and one word
    in 256^(ec − erased) is valid.
    """
    return comb(length - erased, errors) * 255.0**errors / 256.0 ** (ec - erased)
