"""Worked examples and tables printed in ISO/IEC 18004:2015."""

import numpy as np
import pytest
from segno import consts

from perfqr_cad.symbol import LEVELS, blocks, draw, encode, format_word
from perfqr_cad.symbol.galois import generator
from perfqr_cad.symbol.layout import Role, layout, version_word
from perfqr_cad.symbol.payload import parse
from perfqr_cad.symbol.tables import alignment_centres, encoding_modules

SEGNO_LEVELS = dict(
    zip(
        "LMQH",
        (consts.ERROR_LEVEL_L, consts.ERROR_LEVEL_M, consts.ERROR_LEVEL_Q, consts.ERROR_LEVEL_H),
        strict=True,
    )
)


def packed(bits: str) -> bytes:
    """Bytes of a string of bits with blanks, filled with zeros."""
    bits = bits.replace(" ", "")
    return int(bits.ljust(-(-len(bits) // 8) * 8, "0"), 2).to_bytes(-(-len(bits) // 8), "big")


def test_annex_i_codewords_of_01234567() -> None:
    symbol = encode("01234567", version=1, level="M")
    data = "10 20 0C 56 61 80 EC 11 EC 11 EC 11 EC 11 EC 11"
    correction = "A5 24 D4 C1 ED 36 C7 87 2C 55"
    assert symbol.codewords == bytes.fromhex(data + correction)


def test_annex_i_symbol_uses_mask_010() -> None:
    assert encode("01234567", version=1, level="M").mask == 0b010


def test_7_9_1_format_of_level_m_mask_101() -> None:
    assert format_word("M", 0b101) == 0b100000011001110


def test_7_10_version_information_of_version_7() -> None:
    assert version_word(7) == 0b000111110010010100


def test_annex_c_and_d_words() -> None:
    order = ("M", "L", "H", "Q")  # the two level bits count 00, 01, 10, 11
    assert tuple(format_word(level, mask) for level in order for mask in range(8)) == consts.FORMAT_INFO
    assert tuple(version_word(version) for version in range(7, 41)) == consts.VERSION_INFO


@pytest.mark.parametrize(
    ("bits", "text"),
    [
        ("0001 0000001000 0000001100 0101011001 1000011 0000", "01234567"),  # §7.4.3
        ("0010 000000101 00111001110 11100111001 000010 0000", "AC-42"),  # §7.4.4
        ("1000 00000010 0110110011111 1101010101010 0000", "点茗"),  # §7.4.6
    ],
)
def test_7_4_bit_streams(bits: str, text: str) -> None:
    assert parse(packed(bits), 1).text == text


def test_7_4_streams_are_written_alike() -> None:
    assert encode("AC-42", version=1, level="H").data.startswith(
        packed("0010 000000101 00111001110 11100111001 000010")
    )
    kanji = encode("点茗", version=1, level="H", mode="kanji")
    assert kanji.data.startswith(packed("1000 00000010 0110110011111 1101010101010")[:4])


def test_7_4_2_eci_designator_of_the_greek_example() -> None:
    """ECI 000009 and five bytes A1 to A5: the standard's own example."""
    payload = parse(
        packed("0111 00001001 0100 00000101 10100001 10100010 10100011 10100100 10100101 0000"), 1
    )
    assert payload.segments[0].eci == 9
    assert payload.data == bytes(range(0xA1, 0xA6))
    assert payload.text == payload.data.decode("iso8859-7")


def test_7_4_8_3_application_indicator_37() -> None:
    payload = parse(packed("1001 00100101 0010 000000010 00111001100 0000"), 1)
    assert (payload.fnc1, payload.application) == ("aim", "37")
    assert payload.text == "37AA"


def test_8_structured_append_symbol_3_of_7() -> None:
    payload = parse(packed("0011 0010 0110 01010101 0100 00000001 01000001 0000"), 1)
    assert payload.structured_append is not None
    assert (payload.structured_append.index, payload.structured_append.total) == (2, 7)
    assert payload.structured_append.parity == 0x55


def test_annex_a_generator_polynomials() -> None:
    """x⁷ + α⁸⁷x⁶ + α²²⁹x⁵ + α¹⁴⁶x⁴ + α¹⁴⁹x³ + α²³⁸x² + α¹⁰²x + α²¹, and those of every other length."""
    exponents = (87, 229, 146, 149, 238, 102, 21)
    assert generator(7).tolist() == [consts.GALIOS_EXP[k] for k in exponents]
    for length, logs in consts.GEN_POLY.items():
        assert generator(length).tolist() == [consts.GALIOS_EXP[k] for k in logs]


# Table 9: (c, k, r) of the symbols that keep codewords for misdecode protection, and of some that do not.
@pytest.mark.parametrize(
    ("version", "level", "word"),
    [
        (1, "L", (26, 19, 2)), (1, "M", (26, 16, 4)), (1, "Q", (26, 13, 6)), (1, "H", (26, 9, 8)),
        (2, "L", (44, 34, 4)), (2, "M", (44, 28, 8)), (3, "L", (70, 55, 7)), (3, "M", (70, 44, 13)),
        (5, "Q", (33, 15, 9)), (8, "M", (60, 38, 11)), (40, "L", (148, 118, 15)), (40, "H", (45, 15, 15)),
    ],
)  # fmt: skip
def test_table_9_capacity(version: int, level: str, word: tuple[int, int, int]) -> None:
    structure = blocks(version, level)
    assert (structure.data[0] + structure.ec, structure.data[0], structure.capacity) == word


@pytest.mark.parametrize("version", range(1, 41))
def test_tables_1_7_9_and_e1(version: int) -> None:
    assert alignment_centres(version) == (consts.ALIGNMENT_POS[version - 2] if version > 1 else ())
    for level in LEVELS:
        structure = blocks(version, level)
        expected = consts.ECC[version][SEGNO_LEVELS[level]]
        assert structure.data == tuple(part.num_data for part in expected for _ in range(part.num_blocks))
        assert structure.data_codewords * 8 == consts.SYMBOL_CAPACITY[version][SEGNO_LEVELS[level]]


@pytest.mark.parametrize("version", [1, 2, 6, 7, 13, 14, 21, 32, 40])
def test_roles_add_up_to_table_1(version: int) -> None:
    at = layout(version, "Q")
    count = {role: int(np.count_nonzero(at.roles == role)) for role in Role}
    assert sum(count.values()) == (17 + 4 * version) ** 2
    assert (count[Role.FINDER], count[Role.SEPARATOR], count[Role.DARK]) == (3 * 49, 3 * 15, 1)
    assert (count[Role.FORMAT], count[Role.VERSION]) == (30, 36 if version >= 7 else 0)
    assert count[Role.DATA] == 8 * at.blocks.data_codewords
    assert count[Role.EC] == 8 * at.blocks.ec * at.blocks.count
    assert count[Role.DATA] + count[Role.EC] + count[Role.REMAINDER] == encoding_modules(version)
    expected = {1: 0, 2: 7, 6: 7, 7: 0, 13: 0, 14: 3, 21: 4, 32: 3, 40: 0}  # Table 1, remainder bits
    assert count[Role.REMAINDER] == expected[version]


def test_one_format_region_tells_all_words_apart() -> None:
    """What makes "at least one region" of Eq. (3) enough."""
    words = [format_word(level, mask) for level in LEVELS for mask in range(8)]
    assert len({word & 0xFF for word in words}) == len({word >> 8 for word in words}) == 32


def test_finder_alignment_and_timing_are_drawn_as_in_figure_3() -> None:
    dark = draw(2, "L", 0, encode("1", version=2, level="L").codewords).dark
    finder = ["#######", "#.....#", "#.###.#", "#.###.#", "#.###.#", "#.....#", "#######"]
    rows = ["".join("#" if module else "." for module in row) for row in dark]
    assert (
        [row[:7] for row in rows[:7]]
        == [row[-7:] for row in rows[:7]]
        == [row[:7] for row in rows[-7:]]
        == finder
    )
    assert [row[16:21] for row in rows[16:21]] == ["#####", "#...#", "#.#.#", "#...#", "#####"]
    assert rows[6][7:18] == ".#.#.#.#.#."
