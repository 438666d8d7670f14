"""From a message to a symbol (ISO/IEC 18004 §7)."""

from __future__ import annotations

from itertools import cycle, islice
from typing import Any, Final, Literal

import numpy as np

from perfqr_cad.errors import SymbolError
from perfqr_cad.remedy import Remedy
from perfqr_cad.symbol.drawing import Symbol
from perfqr_cad.symbol.galois import parity
from perfqr_cad.symbol.layout import layout
from perfqr_cad.symbol.masks import penalty
from perfqr_cad.symbol.payload import ALPHANUMERIC, payload_of
from perfqr_cad.symbol.segmentation import segmentation
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
FNC1_FIRST, FNC1_BITS = 0b0101, 4  # Table 2
VERSIONS_OF_WIDTH: Final = (9, 26, 40)  # the last ones with equally wide character counts (Table 3)

TextMode = Literal["numeric", "alphanumeric", "byte", "kanji", "mixed"]
_TEXT_MODES: Final[tuple[TextMode, ...]] = ("numeric", "alphanumeric", "byte")  # shortest first


def encode(
    text: str | bytes,
    *,
    version: int | None = None,
    level: Level = "M",
    mask: int | None = None,
    boost: bool = False,
    mode: TextMode | None = None,
    eci: bool = True,
    pads: bytes | None = None,
    fnc1: bool = False,
) -> Symbol:
    """The symbol of a text, or of bytes as they are.

    version  1-40; None takes the smallest that fits
    level    error correction level; `boost` raises it as far as the version permits
    mask     0-7; None takes the one with the least penalty (§7.8.3)
    mode     None takes the first of numeric, alphanumeric and byte that can hold the text; "mixed" cuts ASCII
             text into segments so that it takes the fewest bits
    eci      labels text that is not ASCII as UTF-8 (ECI 26); without the label zbar takes it for Shift-JIS
    fnc1     marks GS1 data by FNC1 in first position (§7.4.8.2); group separators stand as they are
    pads     codewords to put after the terminator instead of 0xEC, 0x11, …, as many as `free_codewords` says

    Text in byte mode is UTF-8; bytes stay as they are. Kanji mode must be asked for: it is the shortest
    for Japanese text, but OpenCV and WeChat hand out its Shift-JIS as if it were UTF-8. SymbolError when
    the message is empty or does not fit; it names the capacity and the version or level that fits.

    >>> symbol = encode("HELLO", level="H")
    >>> symbol.version, symbol.size, symbol.mask
    (1, 21, 3)
    """
    level = check_level(level)
    segments, version = _fitted(text, mode, version, level, eci, fnc1)
    if boost:
        level = next(k for k in reversed(LEVELS) if _length(segments, version, eci) <= _capacity(version, k))
    data = _message(segments, version, level, eci, pads, fnc1)
    codewords = interleave(data, version, level)
    if mask is None:
        return with_best_mask(version, level, codewords)
    return Symbol(version, level, check_mask(mask), codewords)


def interleave(data: bytes, version: int, level: Level) -> bytes:
    """All codewords in placed order: `data` split into blocks, error correction added (§7.5, §7.6)."""
    at = layout(version, level)
    ec = at.blocks.ec
    words = np.frombuffer(data, np.uint8)
    placed = np.empty(at.blocks.codewords, np.uint8)
    for group in at.groups:
        count, length = group.shape[0], group.shape[1] - ec
        block_data, words = words[: count * length].reshape(count, length), words[count * length :]
        placed[group] = np.hstack([block_data, parity(block_data, ec)])
    return placed.tobytes()


def with_best_mask(version: int, level: Level, codewords: bytes) -> Symbol:
    """The symbol of these codewords under the mask with the least penalty, the lowest of equals (§7.8.3)."""
    symbols = [Symbol(version, level, mask, codewords) for mask in range(MASKS)]
    return min(symbols, key=lambda symbol: penalty(symbol.matrix.dark))


def free_codewords(symbol: Symbol) -> int:
    """Data codewords after the terminator, at the end of `symbol.data`: they may hold anything.

    >>> free_codewords(encode("HELLO", version=2))
    22
    """
    used = -(-payload_of(symbol).used_bits // CODEWORD_BITS)
    return len(symbol.data) - used


def padded(symbol: Symbol) -> Symbol:
    """The same message padded as §7.4.9 and §7.4.10 prescribe."""
    free = free_codewords(symbol)
    used = payload_of(symbol).used_bits
    bits = np.unpackbits(np.frombuffer(symbol.data, np.uint8))[: CODEWORD_BITS * (len(symbol.data) - free)]
    bits[used:] = 0
    data = np.packbits(bits).tobytes() + bytes(islice(cycle(PAD_CODEWORDS), free))
    return Symbol(symbol.version, symbol.level, symbol.mask, interleave(data, symbol.version, symbol.level))


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


def _fitted(
    text: str | bytes, mode: TextMode | None, version: int | None, level: Level, eci: bool, fnc1: bool
) -> tuple[Any, int]:
    """segno's segments of a message, and the version asked for, or the smallest that fits."""
    if mode != "mixed" or not isinstance(text, str) or not text.isascii() or not text:
        segments = _segments(text, None if mode == "mixed" else mode, fnc1)
        return segments, _fitting_version(segments, version, level, eci)
    from segno import consts, encoder

    def cut(last: int) -> Any:
        parts = segmentation(text, last, fnc1)
        named = [(part, consts.MODE_MAPPING[name]) for name, part in parts]
        return _marked(encoder.prepare_data(named, None, None), fnc1)

    if version is None:
        cuts = {last: cut(last) for last in VERSIONS_OF_WIDTH}
        fits = (k for k, segments in cuts.items() if _length(segments, k, eci) <= _capacity(k, level))
        segments = cuts[next(fits, MAX_VERSION)]
    else:
        segments = cut(check_version(version))
    return segments, _fitting_version(segments, version, level, eci)


def _marked(segments: Any, fnc1: bool) -> Any:
    """The segments with FNC1's indicator counted among their bits."""
    segments.bit_length += FNC1_BITS * fnc1
    return segments


def _segments(text: str | bytes, mode: TextMode | None, fnc1: bool = False) -> Any:
    """segno's segments of a message (its encoder module is untyped)."""
    from segno import consts, encoder

    data = _utf8(text) if isinstance(text, str) else text
    if not data:
        raise SymbolError("the text is empty: give at least one character")
    encoding = "utf-8" if isinstance(text, str) and not data.isascii() else None
    if mode is None:
        # Behind FNC1 "%" stands for a group separator in alphanumeric mode (§7.4.8.2): bytes are plain.
        modes = ("numeric", "byte") if fnc1 and b"%" in data else _TEXT_MODES
        mode = next(name for name in modes if _holds(name, data))
    elif mode == "kanji" and isinstance(text, str):
        data = text.encode("shift_jis", errors="replace")  # "?" is no kanji
    if not _holds(mode, data):
        raise SymbolError(f"{mode} mode cannot hold {text!r:.40}: leave the mode open")
    return _marked(encoder.prepare_data(data, consts.MODE_MAPPING[mode], encoding), fnc1)


def _utf8(text: str) -> bytes:
    try:
        return text.encode("utf-8")
    except UnicodeEncodeError as error:
        raise SymbolError(
            f"character {error.start + 1} of the text, U+{ord(text[error.start]):04X}, is half of a surrogate"
            " pair and has no UTF-8 form: remove it"
        ) from error


def _holds(mode: TextMode, data: bytes) -> bool:
    """Whether a mode can encode these bytes (§7.3)."""
    from segno import encoder

    if mode == "numeric":
        return data.isdigit()
    if mode == "alphanumeric":
        return all(chr(byte) in ALPHANUMERIC for byte in data)
    return mode == "byte" or encoder.is_kanji(data)


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
    raise _overflow(segments, asked, level, smallest, eci)


def _overflow(segments: Any, version: int, level: Level, smallest: int | None, eci: bool) -> SymbolError:
    """What names the length, the capacity and what would fit."""
    length = _length(segments, version, eci)
    lower = [k for k in LEVELS if length <= _capacity(version, k)]
    remedies = [Remedy(version=smallest)] if smallest is not None else []
    remedies += [Remedy(level=lower[-1])] if lower else []
    return SymbolError(
        f"the text needs {-(-length // CODEWORD_BITS)} codewords, version {version}-{level} holds"
        f" {_capacity(version, level) // CODEWORD_BITS}",
        *remedies or ["a shorter text"],
    )


def _message(segments: Any, version: int, level: Level, eci: bool, pads: bytes | None, fnc1: bool) -> bytes:
    """Data codewords: segments, terminator, padding bits and pad codewords (§7.4.9, §7.4.10)."""
    from segno import encoder

    buffer = encoder.Buffer()
    if fnc1:
        buffer.append_bits(FNC1_FIRST, FNC1_BITS)
    for segment in segments:
        encoder.write_segment(buffer, segment, None, encoder.version_range(version), eci)
    capacity = _capacity(version, level)
    bits = np.frombuffer(bytes(buffer.getbits()), np.uint8)
    bits = np.concatenate([bits, np.zeros(min(TERMINATOR_BITS, capacity - len(bits)), np.uint8)])
    data = np.packbits(bits).tobytes()
    free = capacity // CODEWORD_BITS - len(data)
    if pads is not None:
        _check_pads(pads, free)
    return data + (bytes(islice(cycle(PAD_CODEWORDS), free)) if pads is None else pads)
