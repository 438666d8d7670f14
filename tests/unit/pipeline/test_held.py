"""What was asked for by name and is not held is refused, with a remedy that was made."""

from __future__ import annotations

from dataclasses import replace

import pytest

from perfqr_cad import make
from perfqr_cad.errors import DesignError, NotHeldError, UnreadError, WeakError
from perfqr_cad.pipeline import chain
from perfqr_cad.pipeline.design import Design
from perfqr_cad.pipeline.held import advised, require_borne, require_known, require_read
from perfqr_cad.pipeline.promises import promises, require_kept
from perfqr_cad.pipeline.request import Request
from perfqr_cad.scan import DecoderResult, ScanReport
from perfqr_cad.scan.grade import Grade, SymbolGrade
from perfqr_cad.scan.grade.fixed import FixedPatterns


@pytest.fixture(scope="module")
def design() -> Design:
    return make(text="HELLO 123", size_mm=40, draft_deg=0)


def report(**limits_deg: float | None) -> ScanReport:
    """Decoders that read to a tilt of 0, 20 or 40°, or not at all."""
    tilts = (0.0, 20.0, 40.0)
    results = {
        name: DecoderResult(name, tilts, tuple(float(limit is not None and t <= limit) for t in tilts), None)
        for name, limit in limits_deg.items()
    }
    return ScanReport("a", results, {})


@pytest.mark.parametrize(
    ("settings", "limits_deg", "says"),
    [
        ({}, {"zbar": None, "wechat": None}, "none of 2 decoders"),
        ({}, {"zbar": 40, "wechat": None}, "zbar alone of 2 decoders"),
        ({"require": "zbar, wechat"}, {"zbar": None, "wechat": 0, "opencv": 0}, "zbar: required"),
        ({"scan_tilt_deg": 40.0}, {"zbar": 40, "wechat": 20}, "wechat to 20°, asked for 40°"),
        (
            {"scan_tilt_deg": 20.0, "require": "opencv"},
            {"zbar": 40, "wechat": 20, "opencv": 0},
            "opencv to 0°",
        ),
    ],
)
def test_a_part_that_is_not_read_as_asked(settings: dict, limits_deg: dict, says: str) -> None:
    request = Request("a", **settings)
    with pytest.raises(NotHeldError, match=says):
        require_read(request, report(**limits_deg))
    require_read(replace(request, accept_unread=True), report(**limits_deg))


def test_two_engines_are_enough_where_nothing_is_asked() -> None:
    require_read(Request("a"), report(zbar=0, wechat=0, opencv=None))
    require_read(Request("a", scan_tilt_deg=20.0, require="zbar"), report(zbar=20, wechat=40))


def graded_report(overall: float) -> ScanReport:
    fixed = FixedPatterns({"A1": overall}, {"A1": 0})
    grade = Grade("ISO/IEC 15415:2024", 0.8, 2.0, {}, {"fixed pattern damage": overall}, fixed)
    found = report(zbar=20, wechat=20)
    return replace(found, grade=SymbolGrade({"dark": (grade, grade)}))


def test_a_grade_that_was_asked_for_must_be_held() -> None:
    require_read(Request("a", grade="B"), graded_report(2.5))
    require_read(Request("a"), graded_report(0.0))  # told, not refused, where none is asked for
    with pytest.raises(UnreadError, match=r"grade 2\.4 \(C\) before dark, limited by fixed pattern damage"):
        require_read(Request("a", grade="B"), graded_report(2.4))
    require_read(Request("a", grade="B", accept_unread=True), graded_report(2.4))


def test_bars_are_chosen_for_a_grade() -> None:
    made = make(text="HELLO 123", size_mm=100, grade="B", ground="black")
    assert made.request.finder == "panel"
    assert made.scan.grade is not None
    assert made.scan.grade.counted.overall >= 2.5
    assert "grade " in made.summary()
    assert made.certificate()["scan"]["grade"]["status"] == "simulated, not verified"
    assert make(text="HELLO 123", size_mm=100, ground="black").request.finder == "recessed"


def test_a_decoder_that_is_not_here_is_named() -> None:
    with pytest.raises(DesignError, match="decoder 'zebra' is not here: require one of zxing-cpp"):
        require_known(Request("a", require="zbar,zebra"))


def test_a_load_that_was_asked_for_must_be_borne(design: Design) -> None:
    kinds = {one.load.name: one for one in design.reinforcement.capacities}
    weak = replace(kinds["fingertip"], bears_n=3.0, asked_n=5.0)
    strong = replace(kinds["push"], bears_n=3.0, asked_n=2.0)
    found = replace(design.reinforcement, capacities=(weak, strong))
    require_borne(Request("a"), found)  # a default that is not held is told, not refused
    require_borne(Request("a", load="push"), found)
    with pytest.raises(
        NotHeldError, match=r"weak: bears 3 N by a fingertip .*, asked 5 N, .* \(--accept-weak"
    ):
        require_borne(Request("a", load="fingertip=5"), found)
    require_borne(Request("a", load="fingertip=5", accept_weak=True), found)


def test_the_remedy_is_the_first_that_works() -> None:
    made: list[Request] = []

    def only_thick(request: Request) -> None:
        made.append(request)
        if request.thickness_mm < 3:
            raise WeakError("weak still")

    told = advised(WeakError("weak"), Request("a", size_mm=40.0), only_thick)
    assert isinstance(told, WeakError)
    assert f"weak: use --bars 3 --bar-height {made[-1].bar_height_mm:g} --thickness" in str(told)
    assert str(told).endswith("which was tried")
    assert made[-1].thickness_mm >= 3


def test_a_change_that_does_not_help_is_not_called_a_remedy() -> None:
    def never(_: Request) -> None:
        raise DesignError("never")

    told = str(advised(UnreadError("black before black"), Request("a", colour="black"), never))
    assert "tried without success: no --colour; --thickness" in told


def test_the_chain_looks_for_a_remedy_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Request] = []

    def once(request: Request, target: object) -> str:
        asked.append(request)
        if request.thickness_mm > 1.3:
            raise UnreadError("unread")
        return "design"

    monkeypatch.setattr(chain, "_once", once)
    with pytest.raises(NotHeldError, match=r"unread: use --thickness 1\.2, which was tried"):
        chain.run(Request("a"))
    assert [request.thickness_mm for request in asked] == [1.6, 1.2]


def test_every_promise_is_in_the_certificate(design: Design) -> None:
    listed = design.certificate()["promises"]
    names = {"readability", "block 1", "payload", "web", "pieces", "watertight", "boundary", "volume"}
    assert {promise["name"] for promise in listed} == names
    assert all(promise["kept"] for promise in listed)
    require_kept(design.promises)


@pytest.mark.parametrize("broken", ["readability", "payload", "web", "pieces", "boundary", "volume"])
def test_a_broken_promise_is_refused(design: Design, broken: str) -> None:
    pattern, solid = design.pattern, design.solid
    match broken:
        case "readability":
            wrong = [(row, column) for row in range(9, 17) for column in range(9, 20)]
            pattern = replace(pattern, observed=pattern.observed.flipped(wrong))
        case "payload":
            other = make(text="HELLO 124", size_mm=40, draft_deg=0, mask=design.symbol.mask).symbol
            pattern = replace(pattern, symbol=other)
        case "web":
            pattern = replace(pattern, spec=replace(pattern.spec, nozzle_mm=0.9))
        case "pieces":
            solid = replace(solid, triangles=solid.triangles.joined(solid.triangles))
        case "boundary":
            solid = replace(solid, valid=False, problems=("an edge is used once",))
        case _:
            solid = replace(solid, volume_mm3=solid.volume_mm3 * 1.01)
    made = promises(pattern, solid)
    assert broken in {promise.name for promise in made if not promise.kept}
    with pytest.raises(DesignError, match="the part fails its own checks: "):
        require_kept(made)
