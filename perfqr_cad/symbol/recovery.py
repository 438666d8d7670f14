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
from perfqr_cad.symbol.masks import mask_pattern
from perfqr_cad.symbol.matrix import Matrix
from perfqr_cad.symbol.payload import Payload, payload_of
from perfqr_cad.symbol.tables import Blocks

FloatArray = NDArray[np.floating]

# Chance that noise passes as a block. Without erasures the least protected symbol of Table 9, 2-L with
# r = 4, comes to 5e-10; erasures may not make it worse than this.
MISDECODE_LIMIT: Final = 1e-9

_SHADE_SCALES: Final = tuple(2.0**k for k in range(-6, 7))  # λ of `misread_chance`
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
        shades = _shades(at, info.mask, log_likelihood)
        for block in failed:
            members = at.codewords_of_block(block)
            found = _correct_erased(placed[members], shades[members], at.blocks.ec)
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
            word = placed[group[row]]
            found = _nearest(word, at.blocks.ec, [])
            if found is None or np.count_nonzero(found != word) > at.blocks.capacity:
                failed.append(first + row)
            else:
                placed[group[row]] = found
    return failed


def _shades(at: Layout, mask: int, log_likelihood: FloatArray) -> FloatArray:
    """(C, 8) log-likelihoods of a 1 in each bit of the codewords, the mask taken off."""
    places = at.modules[..., 0], at.modules[..., 1]
    return log_likelihood[places] * np.where(mask_pattern(at.version, mask)[places], -1.0, 1.0)


def _correct_erased(word: ByteArray, shades: FloatArray, ec: int) -> tuple[ByteArray, int] | None:
    """A block corrected after erasing its 2, 4, … most doubtful codewords, and their number; or None.

    Forney's generalised minimum distance decoding: the smallest set that gives a trustworthy word wins.
    A codeword is as doubtful as it has wrong bits to be expected: Σ P(misread) = Σ 1/(1 + e^|ℓ|).
    """
    doubt = np.sum(np.exp(-np.logaddexp(0.0, np.abs(shades))), axis=1)
    order: list[int] = np.argsort(-doubt, kind="stable").tolist()
    for erased in range(2, ec, 2):
        found = _nearest(word, ec, order[:erased])
        if found is None:
            continue
        errors = int(np.count_nonzero(np.delete(found != word, order[:erased])))
        chances = misdecode_chance(len(word), ec, erased, errors), misread_chance(found, shades, ec)
        if min(chances) <= MISDECODE_LIMIT:
            return found, erased
    return None


def _nearest(word: ByteArray, ec: int, erased: list[int]) -> ByteArray | None:
    """The valid word nearest to this one with some of its codewords erased; None when there is none."""
    reedsolo = _reedsolo()
    try:
        data, check, _ = reedsolo.rs_correct_msg(bytearray(word.tobytes()), ec, erase_pos=erased)
    except reedsolo.ReedSolomonError:
        return None
    found = np.frombuffer(bytes(data + check), np.uint8)
    return found if bool(valid(found[None], ec)[0]) else None


@cache
def _reedsolo() -> Any:
    """reedsolo with the tables of this field."""
    import reedsolo

    reedsolo.init_tables(prim=PRIMITIVE)
    return reedsolo


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


def misread_chance(found: ByteArray, shades: FloatArray, ec: int) -> float:
    """Bound on the chance that random shades (n, 8) have any valid word as likely as the one found.

    The cost of a word is the Σ|ℓ| of the bits in which it contradicts the shades. Σ e^λ(cost(found) − cost),
    over all words, counts at least those that are as likely; it factors into bits. One word in 256^ec is
    valid. This holds for every λ > 0: the best of a few makes the scale of the shades irrelevant.
    """
    bits = np.unpackbits(found[:, None], axis=1).astype(np.bool_)
    certainty = np.abs(shades)
    cost = float(np.sum(certainty[bits != (shades > 0)]))
    logs = [scale * cost + float(np.sum(np.logaddexp(0.0, -scale * certainty))) for scale in _SHADE_SCALES]
    return float(np.exp(min(0.0, min(logs) - ec * np.log(256.0))))
