"""One self-contained page; sections without a measurement say so."""

from __future__ import annotations

import base64
import re
import shutil
import subprocess
from dataclasses import dataclass, replace
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from perfqr_cad.export import report
from perfqr_cad.pattern import Bridge
from perfqr_cad.scan import DecoderResult, FilmedView, ScanReport
from perfqr_cad.structure import Reinforcement
from perfqr_cad.symbol import Matrix, encode

from ..conftest import Drawn

VOID = {"meta", "img", "br"}


@dataclass(frozen=True)
class Coded(Drawn):
    symbol: Any = None
    observed: Any = None
    module_mm: float = 1.0


class Outline(HTMLParser):
    """Checks that elements nest, and collects headings and addresses."""

    def __init__(self):
        super().__init__()
        self.open, self.headings, self.addresses = [], [], []

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


def outline(text):
    parser = Outline()
    parser.feed(text)
    assert not parser.open
    return parser


@pytest.fixture(scope="module")
def design(code):
    symbol = encode("TEXT", version=1, level="M")
    dark = symbol.matrix.dark.copy()
    dark[12, 12] ^= True
    bridge = Bridge((1.5, -2.0), (2.5, -2.0), 0.4, "structural", 1.0)
    pattern = Coded(code.pattern.region, (bridge,), symbol=symbol, observed=Matrix(dark))
    facts = {
        "payload": "TEXT & <more>",
        "symbol": {"version": 1, "level": "M"},
        "readability": {"loss": 0.01, "blocks": [{"errors": e, "capacity": 4} for e in (1, 0, 0)]},
        "structure": {"material": "PLA", "max_stress_mpa": None, "mass_g": 4.2, "safety_factor": 1.3},
        "timings_s": {"scan": 12.345},
    }
    return replace(code, pattern=pattern, facts=facts)


@pytest.fixture(scope="module")
def filmed(design):
    grey = np.full((60, 80), 200, np.uint8)
    results = {
        "zbar": DecoderResult("zbar", (0.0, 30.0), (1.0, 0.5), (1.0, 1.0)),
        "OpenCV": DecoderResult("OpenCV", (0.0, 30.0), (0.0, 0.0), (1.0, 1.0)),
    }
    missed = FilmedView(grey, 30.0, 90.0, ())
    return replace(
        design,
        scan=ScanReport("TEXT", results, {"black": 0.95}, first_missed=missed, advice=("thin the bridge",)),
    )


@pytest.fixture(scope="module")
def text(filmed, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    report.write(filmed, path)
    return path.read_text("utf-8")


def test_sections_nest_and_come_in_the_order_of_the_chain(text):
    assert outline(text).headings == ["Readability", "One piece", "Strength", "Solid", "Scan"]


def test_nothing_comes_from_a_network(text):
    assert all(address.startswith("data:image/png;base64,") for address in outline(text).addresses)
    style = text[text.index("<style>") : text.index("</style>")]
    assert "url(" not in style
    assert "@import" not in style
    assert "<script" not in text


def test_facts_are_there_and_escaped(text):
    assert "TEXT &amp; &lt;more&gt;" in text
    assert "<th>block 1</th><td>1 of 4</td>" in text
    assert "<th>blocks 2–3</th><td>0 of 4</td>" in text
    assert "not measured" in text
    assert "1 for strength (green)" in text
    assert "PLA, 4.2 g" in text


def test_scan_is_shown(text):
    assert text.count("all to 0°") == 1
    assert text.count("no view") == 1
    assert text.count("all to 30°") == 2  # the flat print, by both
    assert "The first view that one misses: 30° from azimuth 90°, read by none" in text
    assert "thin the bridge" in text
    assert "95.0%" in text


def test_a_link_that_has_not_run_is_said_to_be_missing(design, tmp_path):
    report.write(design, tmp_path / "report.html")
    assert "Not filmed." in (tmp_path / "report.html").read_text("utf-8")


def field(stress_mpa):
    """What the page reads of a stress field: two triangles over a square, the measure at their corners."""
    nodes = np.array([[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]])
    largest = float(stress_mpa.max())
    return SimpleNamespace(
        uv_mm=nodes, triangles=np.array([[0, 1, 2], [0, 2, 3]]), von_mises_mpa=stress_mpa,
        deflection_mm=np.linspace(0, -0.1, 4), max_stress_mpa=largest, max_stress_at_mm=(10.0, 10.0),
        max_deflection_mm=0.1, max_deflection_at_mm=(-10.0, 10.0), yield_mpa=2.0,
        safety_factor=2.0 / largest, material="PLA",
    )  # fmt: skip


@pytest.fixture
def reinforced(design):
    before, after = field(np.array([0.0, 3.0, 3.0, 3.0])), field(np.array([0.0, 1.5, 1.5, 1.5]))
    bridges = design.pattern.bridges
    loop = Reinforcement(design.pattern, before, after, bridges, 1, 1, "strong", (3.0, 1.5), "optimal", 2.0)
    return replace(design, stress=after, reinforcement=loop)


def pictures(text):
    found = re.findall(r"data:image/png;base64,([^\"]+)", text)
    return [cv2.imdecode(np.frombuffer(base64.b64decode(d), np.uint8), cv2.IMREAD_COLOR) for d in found]


def test_maps_before_and_after_share_their_scale(reinforced, tmp_path):
    report.write(reinforced, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text("utf-8")
    outline(text)
    assert "Von Mises stress, before reinforcement" in text
    assert "Largest stress as bridges were added (1)" in text
    _, before, _, after, _ = pictures(text)
    # The scale ends in pale yellow: reached before, not after.
    assert pale_yellow(before) > 0.01
    assert pale_yellow(after) == 0


def pale_yellow(picture):
    """Share of such pixels left of the colour bar, in a BGR picture."""
    blue, green, red = np.moveaxis(picture[:, : picture.shape[1] * 3 // 4].astype(int), 2, 0)
    return ((red > 220) & (green > 220) & (blue < 200)).mean()


def test_maps_as_made_only_when_nothing_was_added(reinforced, tmp_path):
    plain = replace(reinforced, reinforcement=replace(reinforced.reinforcement, bridges=()))
    report.write(plain, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text("utf-8")
    assert "Deflection, as made" in text
    assert "before reinforcement" not in text


def test_no_clock_in_the_page(text, filmed, tmp_path):
    report.write(filmed, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_text("utf-8") == text
    assert "12.345" not in text
    assert not re.search(r"20\d\d-\d\d-\d\d", text)


@pytest.mark.skipif(not shutil.which("chromium"), reason="chromium is not installed")
def test_a_browser_lays_it_out(text, tmp_path):
    """A screenshot: the picture to the left, the pattern with its green bar to the right."""
    (tmp_path / "report.html").write_text(text, "utf-8")
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    command += ["--window-size=1100,800", "--screenshot=page.png", "report.html"]
    subprocess.run(command, capture_output=True, timeout=120, check=True, cwd=tmp_path)
    page = cv2.imread(str(tmp_path / "page.png"))[..., ::-1].astype(int)
    assert page.shape == (800, 1100, 3)
    green = (page[..., 1] - page[..., 0] > 60) & (page[..., 1] - page[..., 2] > 40)
    assert green.any()
    assert np.nonzero(green)[1].min() > 550
