"""From a message to a symbol (ISO/IEC 18004 §7)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle, islice
from typing import Any, Final

import numpy as np

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.drawing import Symbol
from perfqr_cad.symbol.galois import parity
from perfqr_cad.symbol.layout import layout
from perfqr_cad.symbol.masks import penalty
from perfqr_cad.symbol.payload import ALPHANUMERIC, payload_of
from perfqr_cad.symbol.tables import (
    CODEWORD_BITS,
    LEVELS,
    MASKS,
    MAX_VERSION,
    MIN_VERSION,
    Level,
    blocks,
    check_level,
    check_mask,
    check_version,
)

PAD_CODEWORDS: Final = b"\xec\x11"  # §7.4.10, alternately
TERMINATOR_BITS: Final = 4


def encode(
    text: str | bytes,
    *,
    version: int | None = None,
    level: Level = "M",
    mask: int | None = None,
    boost: bool = False,
    eci: bool = False,
    pads: bytes | None = None,
) -> Symbol:
    """The symbol of a text, or of bytes as they are.

    version  1-40; None takes the smallest that fits
    level    error correction level; `boost` raises it as far as the version permits
    mask     0-7; None takes the one with the least penalty (§7.8.3)
    eci      writes an ECI designator (26) before text that is not ASCII
    pads     codewords to put after the terminator instead of 0xEC, 0x11, …, as many as `free_codewords` says

    Digits and upper-case text use the numeric and alphanumeric modes, text wholly of Shift-JIS double-byte
    characters the kanji mode, all other text UTF-8 bytes. SymbolError when the message does not fit; it
    names the capacity and the smallest version or the level that fits.
    """
    level = check_level(level)
    segments = _segments(text)
    version = _fitting_version(segments, version, level, eci)
    if boost:
        level = next(k for k in reversed(LEVELS) if _length(segments, version, eci) <= _capacity(version, k))
    data = _message(segments, version, level, eci, pads)
    codewords = interleave(data, version, level)
    if mask is None:
        return with_best_mask(version, level, codewords)
    return Symbol(version, level, check_mask(mask), codewords)


def interleave(data: bytes, version: int, level: Level) -> bytes:
    """All codewords in placed order: `data` split into blocks, error correction added (§7.5, §7.6)."""
    structure = blocks(version, level)
    placed = np.empty(structure.codewords, np.uint8)
    at = layout(version, level)
    starts = np.concatenate([[0], np.cumsum(structure.data)])
    words = np.frombuffer(data, np.uint8)
    for length in sorted(set(structure.data)):
        members = [k for k, count in enumerate(structure.data) if count == length]
        block_data = np.stack([words[starts[k] : starts[k] + length] for k in members])
        full = np.hstack([block_data, parity(block_data, structure.ec)])
        for k, word in zip(members, full, strict=True):
            placed[at.codewords_of_block(k)] = word
    return placed.tobytes()


def with_best_mask(version: int, level: Level, codewords: bytes) -> Symbol:
    """The symbol of these codewords under the mask with the least penalty, the lowest of equals (§7.8.3)."""
    symbols = [Symbol(version, level, mask, codewords) for mask in range(MASKS)]
    return min(symbols, key=lambda symbol: penalty(symbol.matrix.dark))


def free_codewords(symbol: Symbol) -> int:
    """Data codewords after the terminator, at the end of `symbol.data`: they may hold anything."""
    used = -(-payload_of(symbol).used_bits // CODEWORD_BITS)
    return len(symbol.data) - used


def with_pads(symbol: Symbol, pads: bytes, mask: int | None = None) -> Symbol:
    """The same message with other codewords after the terminator, and another mask if given.

    SymbolError unless there are exactly `free_codewords(symbol)` pads.
    """
    free = _check_pads(pads, free_codewords(symbol))
    data = symbol.data[: len(symbol.data) - free] + pads
    codewords = interleave(data, symbol.version, symbol.level)
    return Symbol(symbol.version, symbol.level, symbol.mask if mask is None else check_mask(mask), codewords)


def _check_pads(pads: bytes, free: int) -> int:
    if len(pads) != free:
        raise SymbolError(f"{len(pads)} pad codewords given, {free} are free: give exactly {free}")
    return free


def _segments(text: str | bytes) -> Any:
    """segno's segments of a message (segno has no stubs for its encoder)."""
    from segno import consts, encoder

    data = text.encode("utf-8") if isinstance(text, str) else bytes(text)
    plain = data.isdigit() or all(chr(byte) in ALPHANUMERIC for byte in data)
    if data and plain:
        return encoder.prepare_data(data, None, None)
    if isinstance(text, str) and (japanese := _kanji(text)) is not None:
        return encoder.prepare_data(japanese, consts.MODE_KANJI, None)
    return encoder.prepare_data(data, consts.MODE_BYTE, "utf-8" if not data.isascii() else None)


def _kanji(text: str) -> bytes | None:
    """Shift-JIS bytes when every character is one of the kanji mode, else None."""
    from segno import encoder

    try:
        data = text.encode("shift_jis")
    except UnicodeEncodeError:
        return None
    return data if encoder.is_kanji(data) else None


def _capacity(version: int, level: Level) -> int:
    """Data bits."""
    return blocks(version, level).data_codewords * CODEWORD_BITS


def _length(segments: Any, version: int, eci: bool) -> int:
    """Bits of the message without terminator."""
    return int(segments.bit_length_with_overhead(version, eci))


def _fitting_version(segments: Any, version: int | None, level: Level, eci: bool) -> int:
    """The version asked for, or the smallest that fits."""
    versions = range(MIN_VERSION, MAX_VERSION + 1)
    smallest = next((k for k in versions if _length(segments, k, eci) <= _capacity(k, level)), None)
    if version is None and smallest is not None:
        return smallest
    asked = MAX_VERSION if version is None else check_version(version)
    if smallest is not None and smallest <= asked:
        return asked
    raise SymbolError(_overflow(segments, asked, level, smallest, eci))


def _overflow(segments: Any, version: int, level: Level, smallest: int | None, eci: bool) -> str:
    """Message naming the length, the capacity and what would fit."""
    length = _length(segments, version, eci)
    lower = [k for k in LEVELS if length <= _capacity(version, k)]
    remedies = [f"version {smallest}"] if smallest is not None else []
    remedies += [f"level {lower[-1]}"] if lower else []
    remedy = f"use {' or '.join(remedies)}" if remedies else "shorten it"
    return (
        f"the text needs {-(-length // CODEWORD_BITS)} codewords, version {version}-{level} holds"
        f" {_capacity(version, level) // CODEWORD_BITS}: {remedy}"
    )


def _message(segments: Any, version: int, level: Level, eci: bool, pads: bytes | None) -> bytes:
    """Data codewords: segments, terminator, padding bits and pad codewords (§7.4.9, §7.4.10)."""
    from segno import encoder

    buffer = encoder.Buffer()
    for segment in segments:
        encoder.write_segment(buffer, segment, None, encoder.version_range(version), eci)
    capacity = _capacity(version, level)
    bits = np.frombuffer(bytes(buffer.getbits()), np.uint8)
    bits = np.concatenate([bits, np.zeros(min(TERMINATOR_BITS, capacity - len(bits)), np.uint8)])
    data = np.packbits(bits).tobytes()
    free = capacity // CODEWORD_BITS - len(data)
    if pads is not None:
        _check_pads(pads, free)
    return data + bytes(islice(_standard_pads() if pads is None else iter(pads), free))


def _standard_pads() -> Iterator[int]:
    return cycle(PAD_CODEWORDS)
