"""Reed-Solomon correction beside reedsolo, an independent implementation."""

import numpy as np
import pytest
import reedsolo

from perfqr_cad.symbol.correction import nearest
from perfqr_cad.symbol.galois import PRIMITIVE, parity, syndromes


@pytest.fixture(scope="module")
def witness():
    """reedsolo with the tables of QR codes."""
    reedsolo.init_tables(prim=PRIMITIVE)
    return reedsolo


@pytest.mark.parametrize("ec", [7, 10, 13, 17, 22, 30])
def test_parity_and_syndromes_are_those_of_reedsolo(witness, ec: int) -> None:
    data = np.random.default_rng(ec).integers(0, 256, (3, 40), np.uint8)
    data[1] = 0
    words = np.hstack([data, parity(data, ec)])
    assert not syndromes(words, ec).any()
    assert [word.tobytes() for word in words] == [
        bytes(witness.rs_encode_msg(row.tobytes(), ec)) for row in data
    ]
    words[:, 5] ^= 77
    assert syndromes(words, ec).tolist() == [
        list(witness.rs_calc_syndromes(word.tobytes(), ec)[1:]) for word in words
    ]


@pytest.mark.parametrize(("length", "ec"), [(26, 7), (26, 10), (44, 16), (45, 30), (148, 30)])
def test_every_mix_of_errors_and_erasures_up_to_the_limit_is_corrected(length: int, ec: int) -> None:
    random = np.random.default_rng(length)
    data = random.integers(0, 256, (1, length - ec), np.uint8)
    word = np.hstack([data, parity(data, ec)])[0]
    for erasures in range(ec + 1):
        errors = (ec - erasures) // 2
        at = random.permutation(length)[: erasures + errors]
        received = word.copy()
        received[at] ^= random.integers(1, 256, len(at), np.uint8)
        received[at[:1]] = word[at[:1]]  # an erasure may be right by chance
        found = nearest(received, syndromes(received[None], ec)[0], at[:erasures].tolist())
        assert found is not None
        assert np.array_equal(found, word)


@pytest.mark.parametrize(("length", "ec"), [(26, 10), (33, 18), (60, 22)])
def test_beyond_the_limit_it_answers_like_reedsolo(witness, length: int, ec: int) -> None:
    """Up to ec − 2 erasures: beside ec − 1, reedsolo 1.7.0 lets an error pass that is one too many."""
    random = np.random.default_rng(ec)
    for _ in range(100):
        received = random.integers(0, 256, length, np.uint8)
        erased = random.permutation(length)[: random.integers(0, ec - 1)].tolist()
        found = nearest(received, syndromes(received[None], ec)[0], erased)
        try:
            theirs = b"".join(witness.rs_correct_msg(bytearray(received), ec, erase_pos=erased)[:2])
        except witness.ReedSolomonError:
            theirs = None
        assert (None if found is None else found.tobytes()) == theirs
