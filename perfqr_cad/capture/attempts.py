"""Where in a picture to look for codes: guesses by decoders and by our own search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from perfqr_cad.capture.finders import triples
from perfqr_cad.capture.grid import Floats, project
from perfqr_cad.capture.pictures.image import Picture
from perfqr_cad.capture.pictures.views import greys, reduced, searched
from perfqr_cad.capture.seeds import Seed, opencv_seeds, wechat_seeds, zxing_seeds

SEEDS_TRIED = 150
SEARCHED_PX = 100e6  # both bound the work on a picture without a readable code
SAME_PLACE = 0.12  # of a symbol's side: seeds nearer than this are one


@dataclass
class Effort:
    """The pixels that a search has looked at, and whether it left views out that would have been too many."""

    looked_at_px: float = 0.0
    is_cut_short: bool = False

    def affords(self, view: Picture) -> bool:
        """Count a view, unless it is too much; the first one never is."""
        if self.looked_at_px and self.looked_at_px + view.size > SEARCHED_PX:
            self.is_cut_short = True
            return False
        self.looked_at_px += view.size
        return True


def seeds(picture: Picture, effort: Effort) -> Iterator[tuple[Picture, Seed]]:
    """Guesses by decoders and by our own search, each with the grey view that shows it; cheapest first."""
    views = greys(picture)
    effort.affords(views[0])
    for decoder in (zxing_seeds, _finder_seeds, wechat_seeds, opencv_seeds):
        yield from ((views[0], seed) for seed in decoder(views[0]))
    for view in filter(effort.affords, views[1:]):
        for decoder in (zxing_seeds, _finder_seeds):
            yield from ((view, seed) for seed in decoder(view))
    for view in views:
        for name, image, back in searched(view):
            if not effort.affords(image):
                continue
            for decoder in (zxing_seeds, _finder_seeds):
                for seed in decoder(image):
                    engine, places = f"{seed.engine}, {name}", project(back, seed.places)
                    yield view, replace(seed, engine=engine, places=places)


def glimpses(grey: Picture) -> Iterator[Seed]:
    """Guesses that cost little in a picture of any size."""
    yield from zxing_seeds(grey)
    small, back = reduced(grey)
    for decoder in (wechat_seeds, _finder_seeds):
        for seed in decoder(small):
            yield replace(seed, places=project(back, seed.places))


def distinct(seeds: Iterator[tuple[Picture, Seed]]) -> Iterator[tuple[Picture, Seed]]:
    """Seeds that are not where another of their view was already, `SEEDS_TRIED` of them at the most."""
    seen: list[tuple[int, Floats]] = []
    for view, seed in seeds:
        place = np.append(seed.places.mean(axis=0), np.ptp(seed.places, axis=0))
        near = SAME_PLACE * float(place[2:].max())
        kind = id(view) + len(seed.places)
        if any(kind == other and np.abs(place - old).max() < near for other, old in seen):
            continue
        seen.append((kind, place))
        yield view, seed
        if len(seen) >= SEEDS_TRIED:
            return


def _finder_seeds(image: Picture) -> Iterator[Seed]:
    for triple in triples(image):
        yield Seed("finders", triple.centres, triple.sizes, None, True)
