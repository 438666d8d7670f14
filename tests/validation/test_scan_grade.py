"""Grades beside a second implementation, and beside zxing-cpp's unused correction; what must fail, fails.

The witness shares nothing with the package but the meaning of a picture and of a symbol: it walks modules in
loops, takes the aperture pixel by pixel, finds codewords by its own zigzag, and has its own tables.
"""

from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import zxingcpp
from scipy.signal import fftconvolve

from perfqr_cad.pattern import PatternSpec, build
from perfqr_cad.scan import Look, plate_scene
from perfqr_cad.scan.camera.look import BLACK
from perfqr_cad.scan.grade import Grade, dpm, graded, letter, print_quality
from perfqr_cad.scan.grade.verifier import Sampled, sampled
from perfqr_cad.symbol import Symbol, encode

SEEDS = 100
WITHIN = 0.1 + 1e-6
ALIGNMENT = {2: (18,), 4: (26,), 5: (30,), 7: (22, 38)}  # centres beside 6, Annex E


@dataclass(frozen=True)
class Witness:
    picture: np.ndarray
    symbol: Symbol
    origin: np.ndarray  # centre of the symbol's first module, in pixels
    module: float

    @property
    def n(self) -> int:
        return len(self.symbol.matrix.dark)

    def mean_in(self, x: float, y: float, aperture: float) -> float:
        """Area-weighted mean over a disc, by 5 x 5 points in every pixel."""
        radius = aperture * self.module / 2
        r = int(radius + 2)
        columns, rows = np.arange(int(x) - r, int(x) + r + 2), np.arange(int(y) - r, int(y) + r + 2)
        fine = (np.arange(5) - 2) / 5
        u = (columns[:, None] + fine).ravel() - x
        v = (rows[:, None] + fine).ravel() - y
        inside = (
            (u**2 + v[:, None] ** 2 <= radius**2).reshape(len(rows), 5, len(columns), 5).mean(axis=(1, 3))
        )
        part = self.picture[
            np.clip(rows, 0, len(self.picture) - 1)[:, None], np.clip(columns, 0, len(self.picture) - 1)
        ]
        return float((part * inside).sum() / inside.sum())

    def everywhere(self, aperture: float) -> np.ndarray:
        """The same at every pixel between the outermost modules' centres, by Fourier transform."""
        radius, r = aperture * self.module / 2, int(aperture * self.module / 2 + 2)
        fine = (np.arange(5 * (2 * r + 1)) - (5 * (2 * r + 1) - 1) / 2) / 5
        disc = (
            (fine**2 + fine[:, None] ** 2 <= radius**2).reshape(2 * r + 1, 5, 2 * r + 1, 5).mean(axis=(1, 3))
        )
        seen = fftconvolve(self.picture, disc / disc.sum(), mode="same")
        x0, y0 = np.round(self.origin - 4 * self.module).astype(int)
        far = round((self.n + 7) * self.module)
        return seen[y0 : y0 + far + 1, x0 : x0 + far + 1]

    def values(self, aperture: float) -> dict[tuple[int, int], float]:
        places = range(-4, self.n + 4)
        return {
            (r, c): self.mean_in(self.origin[0] + c * self.module, self.origin[1] + r * self.module, aperture)
            for r in places
            for c in places
        }

    def is_light(self, r: int, c: int) -> bool:
        inside = 0 <= r < self.n and 0 <= c < self.n
        return not (inside and self.symbol.matrix.dark[r, c])

    def function(self) -> set[tuple[int, int]]:
        """Modules that carry no codeword."""
        n, v = self.n, self.symbol.version
        found = {(r, c) for r in range(9) for c in range(9)}
        found |= {(r, c) for r in range(9) for c in range(n - 8, n)}
        found |= {(r, c) for r in range(n - 8, n) for c in range(9)}
        found |= {(6, k) for k in range(n)} | {(k, 6) for k in range(n)}
        for r, c in self.aligned():
            found |= {(r + a, c + b) for a in range(-2, 3) for b in range(-2, 3)}
        if v >= 7:
            found |= {(a, n - 11 + b) for a in range(6) for b in range(3)}
            found |= {(n - 11 + b, a) for a in range(6) for b in range(3)}
        return found

    def aligned(self) -> list[tuple[int, int]]:
        others = ALIGNMENT.get(self.symbol.version, ())
        lines = (6, *others) if others else ()
        last = self.n - 7
        return [(r, c) for r in lines for c in lines if (r, c) not in {(6, 6), (6, last), (last, 6)}]

    def codewords(self) -> list[list[tuple[int, int]]]:
        taken, path, up = self.function(), [], True
        right = self.n - 1
        while right > 0:
            if right == 6:
                right = 5
            for r in range(self.n - 1, -1, -1) if up else range(self.n):
                path += [(r, c) for c in (right, right - 1) if (r, c) not in taken]
            up, right = not up, right - 2
        return [path[k : k + 8] for k in range(0, len(path) - 7, 8)]

    def unused(self, wrong: set[tuple[int, int]]) -> float:
        """Of the worst block; codewords are dealt out in turn, longer blocks get the surplus at the end."""
        blocks = self.symbol.blocks
        owners = [b for k in range(max(blocks.data)) for b, size in enumerate(blocks.data) if k < size]
        owners += [b for _ in range(blocks.ec) for b in range(blocks.count)]
        bad = [0] * blocks.count
        for owner, places in zip(owners, self.codewords(), strict=True):
            bad[owner] += any(place in wrong for place in places)
        return max(0.0, 1 - 2 * max(bad) / (blocks.ec - blocks.protection))


def table(value: float, four: float, three: float, two: float, one: float) -> float:
    """Linear between whole grades; written out, with no interpolation of numpy's."""
    points = [(four, 4.0), (three, 3.0), (two, 2.0), (one, 1.0)]
    better = (lambda a, b: a >= b) if four > one else (lambda a, b: a <= b)
    if better(value, four):
        return 4.0
    if not better(value, one):
        return 0.0
    for (high, grade), (low, _) in pairwise(points):
        if better(value, low):
            return grade - 1 + (value - low) / (high - low)
    raise AssertionError


def level_of(modulation: float) -> float:
    """The overlay's level that a module just reaches: 0 below 0.2."""
    return table(modulation, 0.5, 0.4, 0.3, 0.2)


def under_overlay(levels: list[float], grade_with) -> float:
    """Every level that occurs is tried, and the grade with all below it wrong."""
    best = 0.0
    for tenth in range(10, 41):
        level = tenth / 10
        best = max(best, min(level, grade_with({k for k, own in enumerate(levels) if own < level - 1e-9})))
    return best


def witnessed(w: Witness, margin: dict[tuple[int, int], float], threshold: float, aperture: float) -> dict:
    """The parameters that both standards share."""
    n, last = w.n, w.n - 7
    levels = {place: level_of(value) if value >= 0 else 0.0 for place, value in margin.items()}
    grades = {}
    corners = [
        [(r, c) for r in range(-4, 8) for c in range(-4, 8)],
        [(r, c) for r in range(-4, 8) for c in range(n - 8, n + 4)],
        [(r, c) for r in range(n - 8, n + 4) for c in range(-4, 8)],
    ]
    segments = [
        under_overlay([levels[p] for p in places], lambda bad: table(len(bad), 0, 1, 2, 3))
        for places in corners
    ]
    for places in ([(6, c) for c in range(8, n - 8)], [(r, 6) for r in range(8, n - 8)]):
        segments.append(
            under_overlay(
                [levels[p] for p in places],
                lambda bad, among=places: table(len(bad) / len(among), 0, 0.07, 0.11, 0.14),
            )
        )
    if w.aligned():
        worst = [
            min(levels[r + a, c + b] for a in range(-2, 3) for b in range(-2, 3)) for r, c in w.aligned()
        ]
        segments.append(under_overlay(worst, lambda bad: table(len(bad) / len(worst), 0, 0.1, 0.2, 0.3)))
    mean = round(sum(segments) / len(segments), 9)
    grades["fixed pattern damage"] = min(*segments, table(mean, 4, 3.5, 3, 2.5))
    one = [(r, 8) for r in (0, 1, 2, 3, 4, 5, 7, 8)] + [(8, c) for c in (7, 5, 4, 3, 2, 1, 0)]
    two = [(8, n - 1 - k) for k in range(8)] + [(n - 7 + k, 8) for k in range(7)]
    infos = [(one, two)]
    if w.symbol.version >= 7:
        upright = [(a, n - 11 + b) for a in range(6) for b in range(3)]
        infos.append((upright, [(c, r) for r, c in upright]))
    found = [
        sum(
            under_overlay([levels[p] for p in copy], lambda bad: table(len(bad), 0, 1, 2, 3)) for copy in pair
        )
        / 2
        for pair in infos
    ]
    grades["format and version"] = min(found)
    wrong = {p for p, value in margin.items() if value < 0}
    grades["unused error correction"] = table(w.unused(wrong), 0.62, 0.5, 0.37, 0.25)
    quiet = {p for p in margin if not (0 <= p[0] < n and 0 <= p[1] < n)}
    grades["quiet zone"] = 0.0 if quiet & wrong else 4.0
    at = [dark_centre(w, r, c, 2.0, threshold, aperture) for r, c in ((3, 3), (3, n - 4), (n - 4, 3))]
    across, down = (at[1] - at[0]) / last, (at[2] - at[0]) / last
    x, y = np.hypot(*across), np.hypot(*down)
    grades["axial non-uniformity"] = table(abs(x - y) / ((x + y) / 2), 0.06, 0.08, 0.1, 0.12)
    shifts = [
        np.hypot(
            *(dark_centre(w, r, c, 1.0, threshold, aperture) - (at[0] + (c - 3) * across + (r - 3) * down))
        )
        for r, c in w.aligned()
    ]
    even = [
        np.hypot(*(w.origin + w.module * np.array([c, r]) - (at[0] + (c - 3) * across + (r - 3) * down)))
        for r in (0, n - 1)
        for c in (0, n - 1)
    ]
    grades["grid non-uniformity"] = table(max(shifts + even) / ((x + y) / 2), 0.38, 0.5, 0.63, 0.75)
    return grades


def dark_centre(w: Witness, r: int, c: int, reach: float, threshold: float, aperture: float) -> np.ndarray:
    x, y = w.origin + w.module * np.array([c, r])
    far = reach * w.module
    found = [
        (u, v)
        for v in range(round(y - far), round(y + far) + 1)
        for u in range(round(x - far), round(x + far) + 1)
        if w.mean_in(u, v, aperture) < threshold
    ]
    return np.mean(found, axis=0) if found else np.array([x, y])


def modulation_grade(w: Witness, modulation: dict, margin: dict) -> float:
    places = [(r, c) for r in range(w.n) for c in range(w.n)]
    levels = [level_of(modulation[p]) if margin[p] >= 0 else 0.0 for p in places]
    return under_overlay(levels, lambda bad: table(w.unused({places[k] for k in bad}), 0.62, 0.5, 0.37, 0.25))


def by_15415(w: Witness) -> dict[str, float]:
    values = w.values(0.8)
    inside = w.everywhere(0.8)
    low, high = inside.min(), inside.max()
    threshold, contrast = (low + high) / 2, high - low
    margin = {
        p: (1 if w.is_light(*p) else -1) * 2 * (value - threshold) / contrast for p, value in values.items()
    }
    own = {
        "symbol contrast": table(contrast, 0.7, 0.55, 0.4, 0.2),
        "modulation": modulation_grade(w, {p: abs(value) for p, value in margin.items()}, margin),
        "reflectance margin": modulation_grade(w, margin, margin),
    }
    return own | witnessed(w, margin, threshold, 0.8)


@cache
def filmed(finder: str, version: int, size_mm: float, ground: float) -> Sampled:
    symbol = encode("https://example.com/g", version=version)
    pattern = build(symbol, PatternSpec(size_mm=size_mm, finder=finder))
    scene = plate_scene(pattern, 1.6, draft_deg=15.0, lip_mm=0.2)
    look = Look(ground=(ground,) * 3)
    return sampled(scene, look, symbol, module_mm=pattern.module_mm, quiet=4)


KINDS = [
    ("panel", 2, 75.0, 0.04),
    ("recessed", 4, 70.0, 0.2),
    ("panel", 5, 100.0, 0.04),
    ("panel", 7, 120.0, 0.3),
]


def damaged(seed: int) -> Sampled:
    """One of the plates with blotches: dirt in holes, soot on the face, a scratch, a veil of haze."""
    rng = np.random.default_rng(seed)
    seen = filmed(*KINDS[seed % len(KINDS)])
    picture, size = seen.picture.copy(), len(seen.picture)
    y, x = np.mgrid[0:size, 0:size]
    for _ in range(seed // 4 % 6):
        at, radius = rng.uniform(0.05, 0.95, 2) * size, rng.uniform(0.2, 1.0) * seen.module_px
        spot = (x - at[0]) ** 2 + (y - at[1]) ** 2 < radius**2
        picture[spot] += rng.uniform(0.3, 1.0) * (rng.choice([0.04, 0.85]) - picture[spot])
    haze = rng.uniform(0, 0.5) * (seed % 3 == 0)
    picture = picture * (1 - haze) + haze * 0.5
    return replace(seen, picture=picture.astype(np.float32))


def witness_of(seen: Sampled) -> Witness:
    """Where the modules are seen follows from the view alone: a similarity, with no point of the code
    shared."""
    size, n = len(seen.picture), len(seen.light) - 8
    module = 0.9 * size / (n + 8)
    return Witness(seen.picture, seen.symbol, np.full(2, (size - 1) / 2 - (n - 1) / 2 * module), module)


@pytest.mark.parametrize("seeds", [range(k, k + 20) for k in range(0, SEEDS, 20)], ids=lambda s: str(s.start))
def test_a_second_implementation_agrees(seeds):
    found = set()
    for seed in seeds:
        seen = damaged(seed)
        ours, theirs = print_quality(seen), by_15415(witness_of(seen))
        off = {k: (ours.grades[k], theirs[k]) for k in theirs if abs(ours.grades[k] - theirs[k]) > WITHIN}
        assert not off, (seed, off)
        assert set(ours.grades) == set(theirs)
        found |= {round(grade, 1) for grade in ours.grades.values()}
    assert len(found) > 6  # the plates differ


def test_unused_correction_is_that_of_zxing():
    seen = filmed("panel", 7, 180.0, 0.3)
    agreed = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        dark = seen.symbol.matrix.dark.copy()
        places = rng.integers(9, len(dark) - 9, (seed, 2))
        dark[places[:, 0], places[:, 1]] ^= True
        size = seen.module_px * (len(dark) + 8) / 0.9
        pixels = np.floor(
            (np.arange(round(size)) - (round(size) - 1) / 2) / seen.module_px + (len(dark) + 8) / 2
        ).astype(int)
        padded = np.pad(np.where(dark, 0.04, 0.85), 8, constant_values=0.85)
        picture = padded[np.ix_(pixels + 4, pixels + 4)].astype(np.float32)
        found = print_quality(replace(seen, picture=picture)).figures["unused error correction"]
        code = zxingcpp.read_barcodes((picture * 255).astype(np.uint8))
        if code and "UEC" in code[0].extra:
            agreed += 1
            assert found == pytest.approx(code[0].extra["UEC"], abs=0.1), seed
    assert agreed >= 8


def test_what_must_fail_fails():
    seen = filmed("panel", 2, 100.0, 0.04)
    assert print_quality(seen).overall >= 2.5
    gray = replace(seen, picture=np.full_like(seen.picture, 0.5))
    assert print_quality(gray).overall == 0
    assert dpm(gray).overall == 0
    negative = replace(seen, picture=(0.9 - seen.picture).astype(np.float32))
    assert print_quality(negative).overall == 0
    torn = seen.picture.copy()
    torn[: len(torn) // 4] = 0.04
    found = print_quality(replace(seen, picture=torn))
    assert found.grades["fixed pattern damage"] == 0
    assert found.grades["quiet zone"] == 0
    stretched = replace(seen, picture=np.roll(seen.picture, round(seen.module_px), axis=1))
    assert print_quality(stretched).overall == 0


def test_a_see_through_part_is_graded_before_dark_and_light():
    symbol = encode("https://example.com/g", version=2)
    pattern = build(symbol, PatternSpec(size_mm=100.0, finder="panel"))
    scene = plate_scene(pattern, 1.6, draft_deg=15.0, lip_mm=0.2)
    both = graded(scene, Look(), symbol, module_mm=pattern.module_mm, quiet=4)
    assert both.ground == "light"
    assert both.counted.overall == 0
    assert both.grounds["dark"][0].overall >= 2.5
    known = graded(scene, Look(ground=BLACK), symbol, module_mm=pattern.module_mm, quiet=4, ground_known=True)
    assert known.counted.overall == both.grounds["dark"][0].overall
    assert known.counted.written == f"{known.counted.overall:.1f}/95/660"
    assert "simulated, not verified" in known.words
    narrow = graded(scene, Look(), symbol, module_mm=pattern.module_mm, quiet=3, ground_known=True)
    assert narrow.counted.grades["quiet zone"] == 0


def test_letters():
    assert [letter(x) for x in (4.0, 3.5, 2.5, 1.5, 0.5, 0.4)] == list("AABCDF")
    assert isinstance(print_quality(filmed("panel", 2, 100.0, 0.04)), Grade)
