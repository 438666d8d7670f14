"""Reed-Solomon correction of one block, and how far its result can be trusted."""

from __future__ import annotations

from itertools import zip_longest
from math import comb
from typing import Final

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.symbol.galois import EXP, LOG, ORDER, ByteArray, multiply, syndromes

FloatArray = NDArray[np.floating]

# Chance that noise passes as a block. Without erasures the least protected symbol of Table 9, 2-L with
# r = 4, comes to 5e-10; erasures may not make it worse than this.
MISDECODE_LIMIT: Final = 1e-9

_SHADE_SCALES: Final = tuple(2.0**k for k in range(-6, 7))  # λ of `misread_chance`
_ALL: Final = np.arange(256, dtype=np.uint8)
_TIMES: Final = [row.tobytes() for row in multiply(_ALL[:, None], _ALL[None, :])]  # products by factor


def correct_erased(word: ByteArray, shades: FloatArray, ec: int) -> tuple[ByteArray, int] | None:
    """A block corrected after erasing its 2, 4, … most doubtful codewords, and their number; or None.

    Forney's generalised minimum distance decoding: the smallest set that gives a trustworthy word wins.
    A codeword is as doubtful as it has wrong bits to be expected: Σ P(misread) = Σ 1/(1 + e^|ℓ|).
    """
    doubt = np.sum(np.exp(-np.logaddexp(0.0, np.abs(shades))), axis=1)
    order: list[int] = np.argsort(-doubt, kind="stable").tolist()
    syndrome = syndromes(word[None], ec)[0]
    for erased in range(2, ec, 2):
        found = nearest(word, syndrome, order[:erased])
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


def nearest(word: ByteArray, syndrome: ByteArray, erased: list[int]) -> ByteArray | None:
    """The valid word nearest to this one with some of its codewords erased; None when there is none.

    `word` (n,), its syndromes (ec,). Berlekamp-Massey, Chien and Forney as in Blahut, *Algebraic Codes for
    Data Transmission* (2003), §7.4 and §7.5: corrects t errors beside s erasures while 2t + s ≤ ec.
    """
    places = len(word) - 1 - np.arange(len(word))  # of each codeword: logarithm of its locator
    locator = _locator(syndrome.tolist(), places[erased].tolist())
    if locator is None:
        return None
    inverse = (-places) % ORDER
    at = np.flatnonzero(_values(locator, inverse) == 0)
    if len(at) != len(locator) - 1:
        return None
    evaluator = _product(syndrome.tolist(), locator)[: len(syndrome)]
    derivative = [value if power % 2 else 0 for power, value in enumerate(locator)][1:]
    errata = multiply(_values(evaluator, inverse[at]), EXP[places[at]])
    found = word.copy()
    found[at] ^= multiply(errata, EXP[(ORDER - LOG[_values(derivative, inverse[at])]) % ORDER])
    return None if syndromes(found[None], len(syndrome)).any() else found


def _locator(syndrome: list[int], erased: list[int]) -> list[int] | None:
    """Coefficients of ∏(1 − Xx) over all errata, lowest power first; None when they are too many.

    `erased` are the logarithms of the erasures' locators X, from which the recursion starts.
    """
    locator = [1]
    for power in erased:
        locator = _product(locator, [1, int(EXP[power])])
    spare = locator
    degree = len(erased)
    for step in range(len(erased), len(syndrome)):
        discrepancy = 0
        for k, value in enumerate(locator[: step + 1]):
            discrepancy ^= _TIMES[value][syndrome[step - k]]
        spare = [0, *spare]
        if discrepancy:
            changed = _sum(locator, [_TIMES[discrepancy][value] for value in spare])
            if 2 * degree <= step + len(erased):
                degree = step + 1 + len(erased) - degree
                inverse = int(EXP[ORDER - LOG[discrepancy]])
                spare = [_TIMES[inverse][value] for value in locator]
            locator = changed
    while locator[-1] == 0:
        locator.pop()
    fits = len(locator) - 1 == degree and 2 * degree - len(erased) <= len(syndrome)
    return locator if fits else None


def _sum(a: list[int], b: list[int]) -> list[int]:
    """Sum of two polynomials, lowest power first."""
    return [x ^ y for x, y in zip_longest(a, b, fillvalue=0)]


def _product(a: list[int], b: list[int]) -> list[int]:
    """Product of two polynomials, lowest power first."""
    result = [0] * (len(a) + len(b) - 1)
    for k, factor in enumerate(b):
        times = _TIMES[factor]
        for j, value in enumerate(a):
            result[j + k] ^= times[value]
    return result


def _values(polynomial: list[int], logs: NDArray[np.int_]) -> ByteArray:
    """Values of a polynomial, lowest power first, at α^logs."""
    terms = [EXP[(LOG[value] + power * logs) % ORDER] for power, value in enumerate(polynomial) if value]
    return np.bitwise_xor.reduce(terms, axis=0) if terms else np.zeros(len(logs), np.uint8)
