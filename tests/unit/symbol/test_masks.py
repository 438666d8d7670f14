"""Masks and the penalty that chooses one, against the rules written as plain loops."""

import numpy as np
import pytest

from perfqr_cad.symbol import Role, draw, encode, layout, mask_pattern, penalty

CONDITIONS = (  # ISO/IEC 18004:2015 Table 10
    lambda i, j: (i + j) % 2 == 0,
    lambda i, j: i % 2 == 0,
    lambda i, j: j % 3 == 0,
    lambda i, j: (i + j) % 3 == 0,
    lambda i, j: (i // 2 + j // 3) % 2 == 0,
    lambda i, j: (i * j) % 2 + (i * j) % 3 == 0,
    lambda i, j: ((i * j) % 2 + (i * j) % 3) % 2 == 0,
    lambda i, j: ((i + j) % 2 + (i * j) % 3) % 2 == 0,
)


@pytest.mark.parametrize("mask", range(8))
def test_mask_conditions(mask: int) -> None:
    roles = layout(7, "L").roles
    for i in range(45):
        for j in range(45):
            expected = roles[i, j] >= Role.DATA and CONDITIONS[mask](i, j)
            assert mask_pattern(7, mask)[i, j] == expected


def plain_penalty(dark: np.ndarray) -> int:
    """Table 11 rule by rule; the quiet zone is light for the finder-like patterns."""
    size = len(dark)
    points = 0
    for line in [*dark, *dark.T]:
        text = "".join("#" if module else "." for module in line)
        for colour in "#.":
            runs = text.replace("#" if colour == "." else ".", " ").split()
            points += sum(3 + len(run) - 5 for run in runs if len(run) >= 5)
        framed = "." * size + text + "." * size
        for unit in range(1, size // 7 + 1):
            core = "".join(sign * unit * count for sign, count in zip("#.#.#", (1, 1, 3, 1, 1), strict=True))
            at = framed.find("." + core + ".")
            while at >= 0:
                before, after = framed[: at + 1], framed[at + 1 + len(core) :]
                if before.endswith("." * 4 * unit) or after.startswith("." * 4 * unit):
                    points += 40
                at = framed.find("." + core + ".", at + 1)
    for i in range(size - 1):
        for j in range(size - 1):
            points += 3 * (dark[i : i + 2, j : j + 2].sum() in (0, 4))
    percent = 100 * dark.sum() / dark.size
    deviation = max(0, int(-(-abs(percent - 50) // 5)) - 1)
    return int(points + 10 * deviation)


@pytest.mark.parametrize("version", [1, 2, 7])
def test_penalty_is_that_of_the_plain_rules(version: int) -> None:
    symbol = encode("PERFORATED", version=version, level="L")
    for mask in range(8):
        dark = draw(version, "L", mask, symbol.codewords).dark
        assert penalty(dark) == plain_penalty(dark)


@pytest.mark.parametrize("share", [0.02, 0.2, 0.35, 0.5, 0.63, 0.97])
def test_penalty_of_noise(share: float) -> None:
    dark = np.random.default_rng(7).random((21, 21)) < share
    assert penalty(dark) == plain_penalty(dark)


def test_the_chosen_mask_has_the_least_penalty() -> None:
    symbol = encode("perforated", version=4, level="Q")
    penalties = [penalty(draw(4, "Q", mask, symbol.codewords).dark) for mask in range(8)]
    assert symbol.mask == penalties.index(min(penalties))
