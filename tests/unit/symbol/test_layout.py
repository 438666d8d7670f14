"""Module ↔ codeword ↔ block, both ways; the matrix itself."""

import numpy as np
import pytest

from perfqr_cad.errors import SymbolError
from perfqr_cad.symbol import Matrix, Role, Symbol, blocks, deinterleave, encode, interleave, layout


@pytest.mark.parametrize(("version", "level"), [(1, "L"), (5, "Q"), (7, "M"), (14, "H"), (40, "L")])
def test_modules_codewords_and_blocks_are_inverse(version: int, level: str) -> None:
    at = layout(version, level)
    codewords = np.arange(at.blocks.codewords)
    for k in range(8):
        rows, columns = at.modules[:, k].T
        assert np.array_equal(at.codeword_of[rows, columns], codewords)
        assert np.all(at.bit_of[rows, columns] == 7 - k)
        assert np.array_equal(at.block_of[rows, columns], at.block_of_codeword)
    assert np.count_nonzero(at.codeword_of >= 0) == 8 * at.blocks.codewords
    for block in range(at.blocks.count):
        members = at.codewords_of_block(block)
        assert np.all(at.block_of_codeword[members] == block)
        assert np.array_equal(at.place_in_block[members], np.arange(at.blocks.data[block] + at.blocks.ec))
        kinds = at.roles[tuple(at.modules[members, 0].T)]
        assert np.array_equal(kinds == Role.DATA, np.arange(len(members)) < at.blocks.data[block])


def test_format_regions_are_the_four_arms() -> None:
    region = layout(2, "L").format_region
    assert [int(np.count_nonzero(region == k)) for k in range(4)] == [8, 7, 8, 7]
    assert np.all(region[(region >= 0)] == region[layout(2, "L").roles == Role.FORMAT])
    assert set(region[:9, 8]) == {0, -1}
    assert set(region[8, :8]) == {1, -1}
    assert set(region[8, -8:]) == {2}
    assert set(region[-7:, 8]) == {3}
    assert region[-8, 8] == -1


def test_remainder_bits_come_last_and_belong_to_no_block() -> None:
    at = layout(2, "L")
    assert at.remainder.shape == (7, 2)
    assert np.all(at.block_of[tuple(at.remainder.T)] == -1)


def test_blocks_of_version_5_q_are_interleaved() -> None:
    """Two blocks of 15 and two of 16 data codewords: the long ones' last stand alone (§7.6)."""
    structure = blocks(5, "Q")
    data = bytes(range(structure.data_codewords))
    placed = interleave(data, 5, "Q")
    assert list(placed[:8]) == [0, 15, 30, 46, 1, 16, 31, 47]
    assert list(placed[60:62]) == [45, 61]
    symbol = Symbol(5, "Q", 0, placed)
    assert [word[:2] for word in deinterleave(symbol)] == [bytes([k, k + 1]) for k in (0, 15, 30, 46)]
    assert symbol.data == data


def test_layout_is_closed_for_writing() -> None:
    at = layout(3, "L")
    for array in (at.roles, at.modules, at.codeword_of, at.groups[0], encode("1").matrix.dark):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 0


def test_matrix_is_a_value() -> None:
    dark = np.zeros((21, 21), bool)
    matrix = Matrix(dark)
    dark[0, 0] = True
    assert not matrix[0, 0]
    assert (matrix.size, matrix.version) == (21, 1)
    flipped = matrix.flipped([(0, 0), (3, 4)])
    assert (flipped[0, 0], flipped[3, 4], flipped != matrix) == (True, True, True)
    assert flipped.flipped([(0, 0), (3, 4)]) == matrix
    assert hash(Matrix.from_array(np.zeros((21, 21), int))) == hash(matrix)


@pytest.mark.parametrize("shape", [(20, 20), (21, 25), (181, 181), (17, 17), (21, 21, 3)])
def test_shapes_that_are_no_code_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(SymbolError):
        Matrix(np.zeros(shape, bool))


def test_wrong_number_of_codewords_is_refused() -> None:
    with pytest.raises(SymbolError, match="25 codewords given: version 1-L has 26"):
        Symbol(1, "L", 0, bytes(25))
