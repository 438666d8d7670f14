"""Reed-Solomon codes of the symbol over GF(2⁸), first root α⁰ (ISO/IEC 18004 §7.5.2)."""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from perfqr_cad.symbol.matrix import read_only

ByteArray = NDArray[np.uint8]

PRIMITIVE: Final = 0x11D  # x⁸ + x⁴ + x³ + x² + 1
ORDER: Final = 255  # of the multiplicative group


def _powers() -> tuple[ByteArray, NDArray[np.int32]]:
    """α^k for k < 512 (periodic) and the logarithm of 1 … 255."""
    exp = np.zeros(512, np.uint8)
    log = np.zeros(256, np.int32)
    value = 1
    for k in range(ORDER):
        exp[k], log[value] = value, k
        value = value << 1 ^ (value >> 7) * PRIMITIVE
    exp[ORDER:] = np.resize(exp[:ORDER], 512 - ORDER)
    return read_only(exp), read_only(log)


EXP, LOG = _powers()


def multiply(a: ByteArray, b: ByteArray) -> ByteArray:
    """Product in the field, element by element."""
    return np.where((a == 0) | (b == 0), np.uint8(0), EXP[LOG[a] + LOG[b]])


@cache
def generator(ec: int) -> ByteArray:
    """Coefficients after the leading 1 of ∏(x − αᵏ), k < ec, highest power first (Annex A)."""
    poly = np.zeros(ec + 1, np.uint8)
    poly[0] = 1
    for k in range(ec):
        poly[1 : k + 2] ^= multiply(poly[: k + 1], EXP[k : k + 1])
    return read_only(poly[1:])


def parity(data: ByteArray, ec: int) -> ByteArray:
    """Error correction codewords (b, ec) of b data blocks (b, k): the remainder of the division (§7.5.2)."""
    factors = generator(ec)
    rest = np.zeros((data.shape[0], ec), np.uint8)
    for column in data.T:
        lead = column ^ rest[:, 0]
        rest[:, :-1] = rest[:, 1:]
        rest[:, -1] = 0
        rest ^= multiply(lead[:, None], factors[None, :])
    return rest


def syndromes(words: ByteArray, ec: int) -> ByteArray:
    """Values (b, ec) of b received words (b, n) at α⁰ … α^(ec − 1): all zero where a word is valid."""
    terms = EXP[LOG[words][:, :, None] + _root_powers(words.shape[1], ec)]
    terms[words == 0] = 0
    return np.bitwise_xor.reduce(terms, axis=1)


@cache
def _root_powers(length: int, ec: int) -> NDArray[np.int32]:
    """(length, ec) logarithm of what a codeword of the word is multiplied with in each syndrome."""
    return read_only(np.arange(length - 1, -1, -1)[:, None] * np.arange(ec)[None, :] % ORDER)
