# pyright: reportPrivateUsage=false
"""Every remedy that the program can name is listed here, and the part is made with what it changes.

Messages name options through `remedy` alone, so the source tells where remedies are made. Each place has a
request that is refused there; with the remedy the part is drawn, up to its place and its caption.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import segno
import trimesh
from build123d import Box
from PIL import Image

import perfqr_cad
from perfqr_cad.errors import KernelError, PerfQRError, UnreadError, WeakError
from perfqr_cad.export.colour_change import colour_changes
from perfqr_cad.export.cutting import beside
from perfqr_cad.geometry import Region, Triangles
from perfqr_cad.geometry.outline import Loop
from perfqr_cad.hosts.mesh import MeshTarget
from perfqr_cad.hosts.step import ImportedFace
from perfqr_cad.pattern import Bridge, build
from perfqr_cad.pattern.drawing.front import front_with_bars
from perfqr_cad.pipeline.held import ACCEPT_UNREAD, ACCEPT_WEAK, advised, changed
from perfqr_cad.pipeline.request import SETTINGS, Request
from perfqr_cad.pipeline.resolve import resolve
from perfqr_cad.pipeline.source import source
from perfqr_cad.pipeline.targets import Target, locate
from perfqr_cad.remedy import Remedy, option
from perfqr_cad.solid.kernel import occ
from perfqr_cad.structure import solid_check, verify_solid
from tests import pictures

PACKAGE = Path(perfqr_cad.__file__).parent
# Options that messages name as they are.
NOT_SETTINGS = {"--template-timeout", "--json", "--image", "--url", "--wifi"}


@dataclass(frozen=True)
class Refused:
    """Settings that are refused with these words.

    target   what the code is carved into; None: a plate
    provoke  what else leads to the refusal, where no request is known that does
    """

    says: str
    settings: dict[str, Any]
    target: Callable[[], Target] | None = None
    provoke: Callable[[Request], object] | None = None


def refused(says: str, **settings: Any) -> Refused:
    return Refused(says, {"text": "hello"} | settings)


def into(target: Callable[[], Target], says: str, **settings: Any) -> Refused:
    return Refused(says, {"text": "hello"} | settings, target)


def provoked(provoke: Callable[[Request], object], says: str, **settings: Any) -> Refused:
    return Refused(says, {"text": "hello"} | settings, provoke=provoke)


def slab() -> Target:
    return ImportedFace.of(Box(60, 60, 1.6))


def beside_the_middle() -> Target:
    return ImportedFace.of(Box(60, 60, 1.6), point=(10, 0, 0.8))


def mesh() -> Target:
    box: Any = trimesh.creation.box((60, 60, 1.6)).subdivide().subdivide()
    return MeshTarget.of(Triangles(box.vertices, box.faces))


def never(_: Request) -> None:
    raise WeakError("never")


def two_pieces_with_a_bar_between(_: Request) -> None:
    square = Region(Loop.from_points([(0, 0), (1, 0), (1, 1), (0, 1)]))
    front_with_bars([square], [Bridge((5.0, 5.0), (6.0, 5.0), 0.4, "connectivity", 0.0, 0.4)])


def bodies_side_by_side(_: Request) -> None:
    box = SimpleNamespace(name="box", bbox_mm=((0.0, 0.0, 0.0), (1.0, 1.0, 10.0)), colour=(0.0, 0.0, 0.0))
    whole: Any = SimpleNamespace(**{**vars(box), "extras": (box,)})
    colour_changes(whole)


def kerf_wider_than_a_hole(_: Request) -> None:
    beside([Loop.from_points([(0, 0), (0, 1), (1, 1), (1, 0)])], -0.6)


def kernel_that_fails(_: Request) -> None:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf
    from OCP.TopoDS import TopoDS_Solid

    from perfqr_cad.solid.kernel.turn import TURNING

    with occ.kernel(*TURNING):
        BRepBuilderAPI_Transform(TopoDS_Solid(), gp_Trsf(), True)


def in_no_memory(request: Request) -> None:
    terms = resolve(request, plate=True)
    symbol = source(request, terms).symbol
    pattern = build(symbol, terms.drawing)
    site = locate(None, terms, pattern.extent_mm)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(solid_check, "MOST_BYTES", 1.0)
        verify_solid(pattern, site.placement, terms.case_in(site.placement.thickness_mm))


def of(shortfall: type[WeakError | UnreadError]) -> Callable[[Request], object]:
    """The remedy of a shortfall: the first that is tried."""

    def provoke(request: Request) -> None:
        raise advised(shortfall("it is so"), request, drawn)

    return provoke


LONG = "far too much text for it"
SHORTFALLS = [
    provoked(of(WeakError), "use --bars 3 .*which was tried", finger_n=5.0),
    provoked(of(WeakError), "use --finder panel", finger_n=5.0, finder="diagonal"),
    provoked(of(UnreadError), "use no --colour and no --ground", colour="grey", ground="grey"),
    provoked(of(UnreadError), "use no --depth", depth_mm=0.8),
    provoked(of(UnreadError), "use --thickness 1.2"),
    provoked(of(UnreadError), "use --size 50", size_mm=40.0, thickness_mm=0.6),
]

# Where remedies are made: what is refused there.
PLACES: dict[str, list[Refused]] = {
    "capture/several.choice": [refused("use no --which", text=None, image="one.png", which=2)],
    "export/colour_change.colour_changes": [
        provoked(bodies_side_by_side, "share 10 mm of height", colour_change=True, backing_mm=1.0)
    ],
    "export/cutting._beside": [
        provoked(kerf_wider_than_a_hole, "narrower than a kerf", process="laser", kerf_mm=0.2)
    ],
    "hosts/mesh/mesh_search.searched": [into(mesh, "no spot of the mesh", size_mm=59.8)],
    "hosts/place.judged": [into(beside_the_middle, "hangs over", size_mm=55.0)],
    "hosts/step/face_search._on_largest": [into(slab, "no face of", size_mm=70.0)],
    "pattern/compose._kept": [refused("halftone art of its own", text=None, image="art.png", style="dots")],
    "pattern/compose._too_small_for_art": [refused("cost the art", text=None, image="art.png", size_mm=54.0)],
    "pattern/compose._asked": [refused("draws holes", style="dots", tone="inverted")],
    "pattern/drawing/front._opened": [provoked(two_pieces_with_a_bar_between, "on no straight edge")],
    "pattern/drawing/size.module_size": [
        refused("makes modules of", size_mm=10.0),
        refused("makes modules of", size_mm=10.0, style="dots"),
    ],
    "pattern/surround.surrounded": [refused("need the quiet zone", tone="inverted", frame_mm=8.0)],
    "pattern/surround._outline": [
        refused("more than half", size_mm=40.0, corner_radius_mm=500.0, frame_mm=8.0)
    ],
    "pipeline/effect._giving": [refused("use --finder recessed", finder="panel", bars=2)],
    "pipeline/effect._without_effect": [
        refused("no effect without caption", caption_place="top"),
        refused("no effect without finder=recessed", finder="panel", bars=2),
    ],
    "pipeline/held.": SHORTFALLS,
    "pipeline/held.advised": SHORTFALLS,
    "pipeline/held._stronger": SHORTFALLS[:2],
    "pipeline/held._more_legible": SHORTFALLS[2:],
    "pipeline/resolve.makeable": [
        refused("cuts straight through", process="laser", kerf_mm=0.2, draft_deg=8.0),
        into(slab, "cuts flat sheets", process="laser", kerf_mm=0.2, size_mm=40.0),
    ],
    "pipeline/resolve.resolve": [
        refused("before straight walls", lip_mm=0.4, depth_mm=0.8),
        refused("needs a second colour", colour_change=True),
    ],
    "pipeline/resolve._caption": [refused("needs a frame", caption="7")],
    "pipeline/targets.placement": [refused("not seen from behind", mirror=True, depth_mm=0.8)],
    "pipeline/targets.locate": [into(slab, "read from its front", size_mm=40.0, mirror=True)],
    "pipeline/targets._furnished": [
        into(slab, "frame_mm, hole_mm: .* has the part around it", size_mm=40.0, frame_mm=5.0, hole_mm=(3,)),
    ],
    "profile/caption._require_floor": [
        refused("leave less than", caption="7", frame_mm=8.0, caption_relief_mm=-1.4),
        refused("leave less than", caption="7", frame_mm=8.0, caption_relief_mm=-0.4, thickness_mm=0.3),
    ],
    "profile/caption._require_frame": [
        refused("do not fit a frame", caption="gjpqy", frame_mm=4.0, caption_height_mm=8.0)
    ],
    "profile/caption._require_printable": [
        refused("narrower than half", caption="gjpqy", frame_mm=3.0, nozzle_mm=0.6),
        refused("narrower than half", caption="Hi", frame_mm=8.0, caption_height_mm=0.9),
    ],
    "profile/caption._more_room": [
        refused("comes within", caption=LONG, frame_mm=8.0),
        refused("comes within", caption="7777", frame_mm=8.0, size_mm=40.0, hole_mm=((0, -23.5, 3),)),
    ],
    "profile/lettering._require_shapes": [refused("no shape for 'Ⓑ'", caption="Ⓑ", frame_mm=8.0)],
    "profile/sheets.require": [
        refused("cuts sheets of up to 2 mm, not 3 mm", process="knife", thickness_mm=3.0),
        refused("knife cuts no steel", process="knife", material="steel"),
        refused("cannot engrave", process="waterjet", caption="7", frame_mm=8.0),
    ],
    "profile/typeface.typeface": [refused("is not installed", caption="7", frame_mm=8.0, font="Dejavu Sanz")],
    "profile/walls.reach_mm": [refused("leave no floor", depth_mm=1.6)],
    "profile/walls.flare_mm": [refused("nothing to flare", lip_mm=1.6, draft_deg=8.0)],
    "solid/kernel/turn.": [provoked(kernel_that_fails, "turning the part over failed", mirror=True)],
    "structure/solid_check.verify_solid": [
        provoked(in_no_memory, "in three dimensions", text="A", finder="panel", verify_solid=True)
    ],
    "symbol/encoding._overflow": [refused("codewords", text="x" * 200, version=2, level="H")],
}
CASES = [(place, number) for place, cases in PLACES.items() for number in range(len(cases))]


@pytest.mark.parametrize(("place", "number"), CASES)
def test_a_part_is_drawn_with_each_remedy(
    place: str, number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = PLACES[place][number]
    monkeypatch.chdir(tmp_path)
    segno.make("one", micro=False).save("one.png", scale=8)
    Image.fromarray(pictures.halftone(3).picture).save("art.png")
    target = case.target() if case.target else None
    with pytest.raises(PerfQRError, match=case.says) as told:
        _send(case, target)
    assert len(str(told.value).splitlines()) == 1
    assert told.value.remedies
    assert all(str(remedy) in str(told.value) for remedy in told.value.remedies)
    for remedy in told.value.remedies:
        drawn(made_with(case.settings, remedy), target)


def _send(case: Refused, target: Target | None) -> None:
    request = Request(**case.settings)
    if case.provoke is None:
        drawn(request, target)
    else:
        case.provoke(request)


def made_with(settings: dict[str, Any], remedy: Remedy) -> Request:
    """The request with a remedy's changes."""
    left_out = {name for name, value in remedy.changes.items() if value is None}
    return Request(**{name: v for name, v in (settings | remedy.changes).items() if name not in left_out})


def drawn(request: Request, target: Target | None = None) -> None:
    """The chain up to the place of the code and its caption."""
    terms = resolve(request, plate=target is None)
    found = source(request, terms)
    pattern = build(found.symbol, terms.drawing, None if found.capture is None else found.capture.art)
    site = locate(target, terms, pattern.extent_mm)
    if terms.caption is not None:
        terms.caption.placed(pattern, site.placement.thickness_mm)


def test_every_place_that_makes_a_remedy_is_listed() -> None:
    assert set(places()) == set(PLACES)


def places() -> Iterator[str]:
    """Functions that call `Remedy`, as folder/module.function; those at the top of a module without one."""
    for path in sorted(PACKAGE.rglob("*.py")):
        if path.name != "remedy.py":
            module = path.relative_to(PACKAGE).with_suffix("").as_posix()
            yield from (f"{module}.{name}" for name in _makers(ast.parse(path.read_text()), ""))


def _makers(node: ast.AST, within: str) -> Iterator[str]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Call) and ast.unparse(child.func) in ("Remedy", "Tried"):
            yield within
        yield from _makers(child, child.name if isinstance(child, ast.FunctionDef) else within)


def test_no_message_names_an_option_of_a_setting_by_itself() -> None:
    options = {declared.option for declared in SETTINGS}
    named: list[str] = []
    for path in sorted(PACKAGE.rglob("*.py")):
        tree = ast.parse(path.read_text())
        documented = {id(text) for text in _docstrings(tree)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documented:
                words = {word.strip(".,:;()\"'") for word in node.value.split()}
                named += [f"{path.name}:{node.lineno} {word}" for word in words & options - NOT_SETTINGS]
    assert not [one for one in named if not one.startswith(("spine.py", "cli.py"))]


def _docstrings(tree: ast.AST) -> Iterator[ast.Constant]:
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        first = body[0] if isinstance(body, list) and body else None
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            yield first.value


def test_remedies_are_of_settings() -> None:
    known = {declared.field: declared.option for declared in SETTINGS}
    assert {name: option(name) for name in known} == known
    for cases in PLACES.values():
        assert all(set(case.settings) <= set(known) for case in cases)


def test_accepting_is_a_remedy() -> None:
    for remedy in (ACCEPT_WEAK, ACCEPT_UNREAD):
        assert getattr(changed(Request("a", load="weight"), remedy), *remedy.changes) is True


def test_what_does_not_help_is_no_remedy() -> None:
    with pytest.raises(KernelError):
        kernel_that_fails(Request("a"))
    told = advised(WeakError("weak"), Request("a"), never)
    assert not told.remedies
    assert "tried without success" in str(told)
