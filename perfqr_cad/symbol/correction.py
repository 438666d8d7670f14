"""Reed-Solomon correction of one block, and how far its result can be trusted."""

from __future__ import annotations

from functools import cache
from math import comb
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.symbol.galois import PRIMITIVE, ByteArray, valid

FloatArray = NDArray[np.floating]

# Chance that noise passes as a block. Without erasures the least protected symbol of Table 9, 2-L with
# r = 4, comes to 5e-10; erasures may not make it worse than this.
MISDECODE_LIMIT: Final = 1e-9

_SHADE_SCALES: Final = tuple(2.0**k for k in range(-6, 7))  # λ of `misread_chance`


def nearest(word: ByteArray, ec: int, erased: list[int]) -> ByteArray | None:
    """The valid word nearest to this one with some of its codewords erased; None when there is none."""
    reedsolo = _reedsolo()
    try:
        data, check, _ = reedsolo.rs_correct_msg(bytearray(word.tobytes()), ec, erase_pos=erased)
    except reedsolo.ReedSolomonError:
        return None
    found = np.frombuffer(bytes(data + check), np.uint8)
    return found if bool(valid(found[None], ec)[0]) else None


def correct_erased(word: ByteArray, shades: FloatArray, ec: int) -> tuple[ByteArray, int] | None:
    """A block corrected after erasing its 2, 4, … most doubtful codewords, and their number; or None.

    Forney's generalised minimum distance decoding: the smallest set that gives a trustworthy word wins.
    A codeword is as doubtful as it has wrong bits to be expected: Σ P(misread) = Σ 1/(1 + e^|ℓ|).
    """
    doubt = np.sum(np.exp(-np.logaddexp(0.0, np.abs(shades))), axis=1)
    order: list[int] = np.argsort(-doubt, kind="stable").tolist()
    for erased in range(2, ec, 2):
        found = nearest(word, ec, order[:erased])
        if found is None:
            continue
        errors = int(np.count_nonzero(np.delete(found != word, order[:erased])))
        chances = misdecode_chance(len(word), ec, erased, errors), misread_chance(found, shades, ec)
        if min(chances) <= MISDECODE_LIMIT:
            return found, erased
    return None


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


@cache
def _reedsolo() -> Any:
    """reedsolo with the tables of this field."""
    import reedsolo

    reedsolo.init_tables(prim=PRIMITIVE)
    return reedsolo
