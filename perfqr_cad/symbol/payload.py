"""What the data codewords say: segments, bytes and text (ISO/IEC 18004 §7.4)."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import groupby
from typing import Final, Literal

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol.drawing import Symbol
from perfqr_cad.symbol.tables import count_bits

Mode = Literal["numeric", "alphanumeric", "byte", "kanji", "hanzi"]

ALPHANUMERIC: Final = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ $%*+-./:"  # Table 5
GROUP_SEPARATOR: Final = 0x1D  # what FNC1 stands for inside the data (§7.4.8.2)

_MODE_BITS: Final = 4
_TERMINATOR: Final = 0
_STRUCTURED_APPEND: Final = 3
_FNC1_FIRST: Final = 5
_ECI: Final = 7
_FNC1_SECOND: Final = 9
_MODES: Final[dict[int, Mode]] = {1: "numeric", 2: "alphanumeric", 4: "byte", 8: "kanji", 13: "hanzi"}
_GB2312_SUBSET: Final = 1

# ECI assignment number (AIM ECI register) to Python codec; others, such as 899 (binary), are no text.
_CODECS: Final[dict[int, str]] = {
    0: "cp437", 1: "latin-1", 2: "cp437", 3: "latin-1",
    **{number: f"iso8859-{number - 2}" for number in (*range(4, 14), *range(15, 19))},
    20: "shift_jis", 21: "cp1250", 22: "cp1251", 23: "cp1252", 24: "cp1256", 25: "utf-16-be", 26: "utf-8",
    27: "ascii", 28: "big5", 29: "gb18030", 30: "cp949", 31: "gbk", 32: "gb18030", 33: "utf-16-le",
    34: "utf-32-be", 35: "utf-32-le", 170: "ascii",
}  # fmt: skip


@dataclass(frozen=True)
class Segment:
    """One stretch of data: its bytes (kanji: Shift-JIS, hanzi: GB 2312) and the ECI assignment in force."""

    mode: Mode
    data: bytes
    eci: int | None = None


@dataclass(frozen=True)
class StructuredAppend:
    """Place of this symbol in a set of up to 16 (§8). `index` counts from 0."""

    index: int
    total: int
    parity: int


@dataclass(frozen=True)
class Payload:
    """The message. `text` is None when the bytes are no text in any encoding that was tried.

    fnc1 is "gs1" (FNC1 first), "aim" (second; `application` then holds the indicator, which readers put
    in front of the data, as `data` and `text` do here) or None. `used_bits` counts from the first bit to
    the end of the terminator: codewords after it are padding.
    """

    text: str | None
    data: bytes
    segments: tuple[Segment, ...]
    fnc1: Literal["gs1", "aim"] | None = None
    application: str | None = None
    structured_append: StructuredAppend | None = None
    used_bits: int = field(default=0, compare=False)


def payload_of(symbol: Symbol) -> Payload:
    """Payload of a correct symbol. SymbolError when its data codewords are no message.

    >>> from perfqr_cad.symbol import encode
    >>> payload_of(encode("grüezi")).text
    'grüezi'
    """
    return parse(symbol.data, symbol.version)


def parse(data: bytes, version: int) -> Payload:
    """Payload of the data codewords of a version. SymbolError with the place where they stop making sense."""
    bits = _Bits(data)
    segments: list[Segment] = []
    eci: int | None = None
    fnc1: Literal["gs1", "aim"] | None = None
    application: str | None = None
    append: StructuredAppend | None = None
    while bits.left >= _MODE_BITS:
        indicator = bits.take(_MODE_BITS)
        if indicator == _TERMINATOR:
            break
        if indicator == _ECI:
            eci = _eci_number(bits)
        elif indicator == _STRUCTURED_APPEND:
            append = StructuredAppend(bits.take(4), bits.take(4) + 1, bits.take(8))
        elif indicator == _FNC1_FIRST:
            fnc1 = "gs1"
        elif indicator == _FNC1_SECOND:
            fnc1, application = "aim", _application(bits.take(8))
        elif indicator in _MODES:
            mode = _MODES[indicator]
            segments.append(Segment(mode, _characters(bits, mode, version, fnc1 is not None), eci))
        else:
            raise SymbolError(
                f"mode indicator {indicator} at bit {bits.at - _MODE_BITS} is not defined for QR codes:"
                " the symbol was not made by a conforming encoder"
            )
    raw = (application or "").encode() + b"".join(part.data for part in segments)
    text = _text(segments)
    if text is not None and application is not None:
        text = application + text
    return Payload(text, raw, tuple(segments), fnc1, application, append, bits.at)


class _Bits:
    """A reader of big-endian bit fields."""

    def __init__(self, data: bytes) -> None:
        self._value = int.from_bytes(data, "big")
        self._length = 8 * len(data)
        self.at = 0

    @property
    def left(self) -> int:
        return self._length - self.at

    def take(self, width: int) -> int:
        """The next `width` bits as a number. SymbolError when there are not so many."""
        if width > self.left:
            raise SymbolError(
                f"the message wants {width} bits at bit {self.at}, only {self.left} are left:"
                " the symbol was not made by a conforming encoder"
            )
        self.at += width
        return self._value >> (self._length - self.at) & ((1 << width) - 1)


def _eci_number(bits: _Bits) -> int:
    """ECI assignment of one, two or three bytes (§7.4.2.2)."""
    first = bits.take(8)
    if first < 0x80:
        return first
    if first < 0xC0:
        return (first & 0x3F) << 8 | bits.take(8)
    if first < 0xE0:
        return (first & 0x1F) << 16 | bits.take(16)
    raise SymbolError(f"ECI designator starts with byte {first}: below 224 is allowed")


def _application(code: int) -> str:
    """Application indicator of FNC1 in second position: 00-99 or a letter (§7.4.8.3)."""
    if code < 100:
        return f"{code:02d}"
    letter = chr(code - 100)
    if letter.isascii() and letter.isalpha():
        return letter
    raise SymbolError(f"application indicator {code}: 0 to 99, 165 to 190 and 197 to 222 are allowed")


def _characters(bits: _Bits, mode: Mode, version: int, fnc1: bool) -> bytes:
    """Bytes of one segment from its count indicator on."""
    if mode == "hanzi" and (subset := bits.take(4)) != _GB2312_SUBSET:
        raise SymbolError(f"Hanzi subset {subset} is not defined: only {_GB2312_SUBSET} (GB 2312) is")
    count = bits.take(count_bits(mode, version))
    if mode == "numeric":
        return _numeric(bits, count)
    if mode == "alphanumeric":
        return _alphanumeric(bits, count, fnc1)
    if mode == "byte":
        return bits.take(8 * count).to_bytes(count, "big")
    return b"".join(_double_byte(bits.take(13), mode) for _ in range(count))


def _numeric(bits: _Bits, count: int) -> bytes:
    """Three digits in 10 bits, two in 7, one in 4 (§7.4.3)."""
    digits = ""
    while count > 0:
        width = min(count, 3)
        value = bits.take(3 * width + 1)
        if value >= 10**width:
            raise SymbolError(f"numeric group {value} at bit {bits.at} has more than {width} digits")
        digits += f"{value:0{width}d}"
        count -= width
    return digits.encode()


def _alphanumeric(bits: _Bits, count: int, fnc1: bool) -> bytes:
    """Two characters in 11 bits, one in 6 (§7.4.4); under FNC1 "%" is a separator and "%%" a percent sign."""
    text = ""
    while count > 0:
        width = min(count, 2)
        value = bits.take(11 if width == 2 else 6)
        if value >= 45**width:
            raise SymbolError(f"alphanumeric group {value} at bit {bits.at} is not below {45**width}")
        text += (ALPHANUMERIC[value // 45] if width == 2 else "") + ALPHANUMERIC[value % 45]
        count -= width
    if fnc1:
        text = "%".join(part.replace("%", chr(GROUP_SEPARATOR)) for part in text.split("%%"))
    return text.encode()


def _double_byte(value: int, mode: Mode) -> bytes:
    """The two bytes of a 13-bit kanji (§7.4.6) or hanzi (GB/T 18284) character."""
    if mode == "kanji":
        high, low = divmod(value, 0xC0)
        code = high << 8 | low
        code += 0x8140 if code < 0x1F00 else 0xC140
    else:
        high, low = divmod(value, 0x60)
        code = high << 8 | low
        code += 0xA1A1 if code < 0x0A00 else 0xA6A1
    return code.to_bytes(2, "big")


def _text(segments: list[Segment]) -> str | None:
    """Text of all segments, or None. Byte segments without an ECI share one guessed encoding."""
    unlabelled = b"".join(part.data for part in segments if part.mode == "byte" and part.eci is None)
    guess = guess_encoding(unlabelled)
    text = ""
    for codec, run in groupby(segments, key=lambda part: _codec(part, guess)):
        data = b"".join(part.data for part in run)  # a character may span two segments
        part = None if codec is None else _decoded(data, codec)
        if part is None:
            return None
        text += part
    return text


def _codec(segment: Segment, guess: str | None) -> str | None:
    """Codec of a segment, or None when it is no text."""
    if segment.mode in ("numeric", "alphanumeric"):
        return "ascii"
    if segment.mode == "kanji":
        return "shift_jis"
    if segment.mode == "hanzi":
        return "gb2312"
    return guess if segment.eci is None else _CODECS.get(segment.eci)


def _decoded(data: bytes, codec: str) -> str | None:
    """Text of bytes, or None. Shift-JIS of Windows (cp932) has characters that the standard's lacks."""
    for name in ("shift_jis", "cp932") if codec == "shift_jis" else (codec,):
        try:
            return data.decode(name)
        except UnicodeDecodeError:
            continue
    return None


def guess_encoding(data: bytes) -> str | None:
    """Codec of bytes that carry no ECI: UTF-8 if valid, then Shift-JIS if it looks so, Latin-1, or None.

    The standard's default is Latin-1, yet most encoders write UTF-8 and, in Japan, Shift-JIS. As in ZXing,
    Shift-JIS needs either three characters beyond ASCII in a row or bytes that Latin-1 lacks. Control
    characters other than tab, line breaks and FS-US mean binary data.
    """
    if _decoded(data, "utf-8") is not None:
        return "utf-8"
    if any(byte < 0x20 and byte not in b"\t\n\r\x1c\x1d\x1e\x1f" for byte in data):
        return None
    latin = not any(0x7F <= byte < 0xA0 for byte in data)
    japanese = _decoded(data, "shift_jis")
    if japanese is not None and (not latin or _longest_run_beyond_ascii(japanese) >= 3):
        return "shift_jis"
    return "latin-1" if latin else None


def _longest_run_beyond_ascii(text: str) -> int:
    runs = groupby(text, key=str.isascii)
    return max((sum(1 for _ in run) for is_ascii, run in runs if not is_ascii), default=0)
