"""Whatever is out of the ordinary in the package has a reason, and every reason is still needed."""

import runpy
from pathlib import Path

HOUSE = runpy.run_path(str(Path(__file__).parents[1] / "house.py"))


def test_what_is_out_of_the_ordinary_has_a_reason() -> None:
    assert [f"{o.place}: {o.what}" for o in HOUSE["oddities"]() if o.reason is None] == []


def test_no_reason_is_left_over() -> None:
    assert set(HOUSE["REASONS"]) <= {o.place for o in HOUSE["oddities"]()}
