"""The design behind an object: the whole chain, once for equal settings."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from perfqr_cad.pipeline.chain import asked, run
from perfqr_cad.pipeline.design import Design
from perfqr_cad.pipeline.request import Request

KEPT = 32  # designs of one session; a model with more codes than that makes some of them again


def design_of(text: str | None, **settings: Any) -> Design:
    """The flat part that `perfqr_cad.make` makes with these settings; a copy of the same code costs nothing.

    Back at z = 0, front at z = thickness, centre of the code on the z axis, y up. Raises as `make` does.
    """
    return _made(asked(text, **settings))


@lru_cache(maxsize=KEPT)
def _made(request: Request) -> Design:
    return run(request)
