"""Messages of every kind: other encoders write, `payload_of` reads."""

import numpy as np
import pytest
import segno
import zxingcpp
from segno import consts, encoder

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol import Matrix, Payload, encode, payload_of, recover
from perfqr_cad.symbol.payload import guess_encoding, parse


def of_segno(code: segno.QRCode) -> Payload:
    return recover(Matrix.from_array(np.array([list(row) for row in code.matrix]) == 1)).payload


def of_zint(text: str, **options: object) -> Payload:
    """Payload of what zxing-cpp's writer (libzint) draws."""
    code = zxingcpp.create_barcode(text, zxingcpp.BarcodeFormat.QRCode, **options)
    return recover(Matrix(np.array(code.to_image(scale=1, add_quiet_zones=False)) < 128)).payload


@pytest.mark.parametrize(
    ("text", "mode"),
    [
        ("0", "numeric"),
        ("00120034500678", "numeric"),
        ("A", "alphanumeric"),
        ("HTTPS://EXAMPLE.COM/%25", "alphanumeric"),
        ("https://example.com", "byte"),
        ("naïve", "byte"),
        ("ä", "byte"),
        ("日本語 text", "byte"),
        ("😀", "byte"),
    ],
)
def test_text_comes_back_from_our_own_encoder(text: str, mode: str) -> None:
    for eci in (False, True):
        payload = payload_of(encode(text, eci=eci))
        assert payload.text == text
        assert payload.data == text.encode()
        assert [part.mode for part in payload.segments] == [mode]
        assert payload.segments[0].eci == (26 if eci and not text.isascii() else None)


@pytest.mark.parametrize(
    ("content", "options", "text"),
    [
        ("Größe", {"encoding": "latin-1"}, "Größe"),
        ("Größe", {"encoding": "utf-8", "eci": True}, "Größe"),
        ("Ωμέγα", {"encoding": "iso8859-7", "eci": True}, "Ωμέγα"),
        ("Привет", {"encoding": "cp1251", "eci": True}, "Привет"),
        ("テスト文字", {"encoding": "shift_jis", "mode": "byte"}, "テスト文字"),
        ("ﾃｽﾄ", {"encoding": "shift_jis", "mode": "byte"}, "ﾃｽﾄ"),
        ("点茗", {"mode": "kanji"}, "点茗"),
        ("汉字信息", {"mode": "hanzi"}, "汉字信息"),
    ],
)
def test_segno_writes_we_read(content: str, options: dict, text: str) -> None:
    payload = of_segno(segno.make(content, micro=False, **options))
    assert payload.text == text


def test_mixed_segments() -> None:
    parts = [
        ("ABC", consts.MODE_ALPHANUMERIC),
        ("12345", consts.MODE_NUMERIC),
        ("ü!", None),
        ("点", consts.MODE_KANJI),
    ]

    code = encoder.encode(parts, error="M", micro=False)
    payload = recover(Matrix.from_array(np.array([list(row) for row in code.matrix]) == 1)).payload
    assert payload.text == "ABC12345ü!点"
    assert [part.mode for part in payload.segments] == ["alphanumeric", "numeric", "byte", "kanji"]


def test_structured_append_set() -> None:
    text = "structured append " * 6
    codes = segno.make_sequence(text, version=2, error="L")
    payloads = [of_segno(code) for code in codes]
    assert "".join(payload.text or "" for payload in payloads) == text
    places = [payload.structured_append for payload in payloads]
    assert [place and place.index for place in places] == list(range(len(codes)))
    assert {place and place.total for place in places} == {len(codes)}
    assert len({place and place.parity for place in places}) == 1


def test_gs1_of_zint() -> None:
    payload = of_zint("[01]12345678901231[10]AB%C[21]7", gs1=True)
    assert payload.fnc1 == "gs1"
    assert payload.text == "011234567890123110AB%C\x1d217"


@pytest.mark.parametrize(("text", "eci"), [("Ωμέγα", "9"), ("Ωμέγα", "26"), ("日本語", "20"), ("śćżź", "4")])
def test_eci_of_zint(text: str, eci: str) -> None:
    payload = of_zint(text, eci=eci)
    assert payload.text == text
    assert {part.eci for part in payload.segments} == {int(eci)}


@pytest.mark.parametrize("data", [b"\x00\x01\xfe\xff\x80\x81", bytes(range(256)), b"a\x81 b\xfd"])
def test_bytes_that_are_no_text_are_kept(data: bytes) -> None:
    payload = payload_of(encode(data))
    assert payload.data == data
    assert payload.text is None


@pytest.mark.parametrize(
    ("data", "codec"),
    [
        (b"plain", "utf-8"),
        ("é".encode(), "utf-8"),
        ("café".encode("latin-1"), "latin-1"),
        ("±5°".encode("latin-1"), "latin-1"),
        ("日本".encode("shift_jis"), "shift_jis"),
        ("ｱｲｳ".encode("shift_jis"), "shift_jis"),
        (b"\x80\x00", None),
        (b"\xfd\xfe\x81", None),
    ],
)
def test_guessed_encoding(data: bytes, codec: str | None) -> None:
    assert guess_encoding(data) == codec


def test_kanji_of_windows_are_read() -> None:
    """① is in row 13, which cp932 has and JIS X 0208 leaves empty."""
    high, low = divmod(0x8740 - 0x8140, 0x100)
    stream = f"1000{1:08b}{high * 0xC0 + low:013b}0000"
    assert parse(int(stream.ljust(32, "0"), 2).to_bytes(4, "big"), 1).text == "①"


def test_a_character_may_span_two_segments() -> None:
    data = "é".encode()
    bits = "".join(f"0100{1:08b}{byte:08b}" for byte in data) + "0000"
    assert parse(int(bits.ljust(48, "0"), 2).to_bytes(6, "big"), 1).text == "é"


@pytest.mark.parametrize(
    ("bits", "message"),
    [
        ("0100 11111111", "wants 2040 bits at bit 12, only 4 are left"),
        ("0110 0000", "mode indicator 6 at bit 0"),
        ("0111 11100000 0000", "ECI designator starts with byte 224"),
        ("1001 01111111 0000", "application indicator 127"),
        ("0001 0000000011 1111111111", "numeric group 1023"),
        ("0010 000000010 11111111111", "alphanumeric group 2047"),
        ("1101 0010 00000000", "Hanzi subset 2"),
    ],
)
def test_nonsense_is_named(bits: str, message: str) -> None:
    bits = bits.replace(" ", "")
    data = int(bits.ljust(-(-len(bits) // 8) * 8, "0"), 2).to_bytes(-(-len(bits) // 8), "big")
    with pytest.raises(SymbolError, match=message):
        parse(data, 1)


@pytest.mark.parametrize(
    ("bits", "number"), [("01111111", 127), ("1000000110000000", 384), ("110000010000000000000001", 65537)]
)
def test_eci_designators_of_one_two_and_three_bytes(bits: str, number: int) -> None:
    stream = f"0111{bits}0100{1:08b}{65:08b}0000"
    data = int(stream.ljust(-(-len(stream) // 8) * 8, "0"), 2).to_bytes(-(-len(stream) // 8), "big")
    payload = parse(data, 1)
    assert payload.segments[0].eci == number
    assert (payload.data, payload.text) == (b"A", None)


def test_message_that_fills_the_symbol_has_no_terminator() -> None:
    symbol = encode("7" * 41, version=1, level="L")
    assert payload_of(symbol).text == "7" * 41
    assert payload_of(symbol).used_bits <= 19 * 8
