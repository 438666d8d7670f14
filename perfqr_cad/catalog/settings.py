"""From the parameters of a template to the settings of `make`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from perfqr_cad.pipeline.request import SETTINGS, SOURCES


def settings(p: SimpleNamespace) -> dict[str, Any]:
    """The settings of `perfqr_cad.make` among a template's values: `make(**settings(p), target=…)`.

    A picture, or content of another kind, is taken instead of the text.
    """
    given = vars(p)
    made = {s.field: s.read(given[s.python_name]) for s in SETTINGS if s.python_name in given}
    others = any(made.get(name) is not None for name in SOURCES if name != "text")
    return made | {"text": None} if others else made
