"""The front between what rings bear and from where they are read."""

from dataclasses import replace

import pytest

from perfqr_cad.pipeline.holding import ALLOWABLE_MPA, WORST_PLACE, RingHold, front, holding
from perfqr_cad.pipeline.request import Request
from perfqr_cad.pipeline.resolve import resolve

MODULE_MM = 1.6
REQUEST = Request(text="HOLD", size_mm=60.0)


def spec(request):
    return resolve(request, plate=True).drawing


def test_each_hold_of_the_front_bears_more_than_the_one_before():
    bears = [hold.bears_n(MODULE_MM) for hold in front(1.6, 0.4)]
    assert bears == sorted(bears)
    assert bears[-1] > 100 * bears[0]


def test_an_untwisted_bar_bears_what_a_cantilever_does():
    hold = RingHold(2, 0.8, 1.7, 2.0)
    assert hold.bears_n(MODULE_MM) == pytest.approx(
        ALLOWABLE_MPA * 3.4 * 0.8**2 / 6 / (3.5 * MODULE_MM) / WORST_PLACE
    )
    assert hold.bears_n(MODULE_MM, 2 * ALLOWABLE_MPA) == pytest.approx(2 * hold.bears_n(MODULE_MM))


def test_size_does_little_and_height_does_much():
    hold = RingHold(2, 0.4, None, 1.6)
    assert hold.bears_n(1.2) == pytest.approx(hold.bears_n(MODULE_MM), rel=0.1)
    assert replace(hold, height_mm=0.8).bears_n(MODULE_MM) == pytest.approx(4 * hold.bears_n(MODULE_MM))


def test_requests_that_bear_a_force_come_in_the_order_of_the_front():
    found = holding(REQUEST, MODULE_MM, 5.0)
    assert [request.thickness_mm for request in found] == sorted(request.thickness_mm for request in found)
    assert found[0].thickness_mm > REQUEST.thickness_mm
    for request in found:
        asked = spec(request)
        assert (
            RingHold(asked.bars, asked.bar_height_mm, asked.bar_width_mm, request.thickness_mm).bears_n(
                MODULE_MM
            )
            >= 5.0
        )
    assert holding(REQUEST, MODULE_MM, 0.001)[0].bar_width_mm == REQUEST.nozzle_mm


def test_the_strongest_is_left_when_none_bears_the_force():
    (strongest,) = holding(REQUEST, MODULE_MM, 1000.0)
    assert strongest == front(1.6, 0.4)[-1].applied(REQUEST)


def test_bars_that_are_asked_for_stay():
    asked = replace(REQUEST, bar_height_mm=0.6)
    assert holding(asked, MODULE_MM, 5.0) == (asked,)
    assert spec(asked).bar_height_mm == 0.6
    assert spec(replace(asked, scan_tilt_deg=40.0)).bar_height_mm == 0.6
    assert spec(replace(REQUEST, scan_tilt_deg=40.0)).bar_height_mm < 0.4
