"""The command `perfqr`: parse, call, print. No logic.

Figures and JSON go to standard output, progress and errors to standard error. Bad input ends with one
line (value, limit, remedy) and exit code 2.
"""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Generator
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from perfqr_cad import __version__
from perfqr_cad.errors import DesignError, PerfQRError

if TYPE_CHECKING:
    from perfqr_cad.catalog import Value
    from perfqr_cad.table import Table

app = typer.Typer(
    name="perfqr",
    help="Perforated QR codes as real parts: one piece, strong enough, and proven to scan.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # rich help costs 0.15 s of imports at every start
)

BENCHMARKS = ("symbol", "capture", "pattern", "finder", "margin", "structure", "solid", "scan", "spine")
BAD_INPUT, INTERRUPTED = 2, 130  # exit codes; 130 is the shell's own for an interrupt
# What `make` itself uses.
NOT_OF_TEMPLATES = {
    "output",
    "template",
    "define",
    "set_file",
    "set_name",
    "as_json",
}
EXPERIMENTS = ("table1", "table2", "fig9", "fig11", "fig14", "colours", "materials", "limits", "bunny")


class _Level(StrEnum):
    L = "L"
    M = "M"
    Q = "Q"
    H = "H"


def _option(*names: str, help: str) -> Any:
    return typer.Option(*names, help=help)


_Json = Annotated[bool, _option("--json", help="Print JSON on standard output.")]
_TemplateName = Annotated[str, typer.Argument(help="A template's name or a .py file.")]


# Each common setting is one long option here and the parameter of the same name in a template.
@app.command()
def make(
    context: typer.Context,
    text: Annotated[str | None, typer.Argument(help="The text of the code.")] = None,
    image: Annotated[Path | None, _option(help="A picture of a code, instead of a text.")] = None,
    output: Annotated[
        list[str] | None, _option("-o", "--output", help="FILE (suffix = format) or FOLDER/ (all). Repeats.")
    ] = None,
    template: Annotated[str, _option("-t", "--template", help="A template or a .py file.")] = "plate",
    define: Annotated[list[str] | None, _option("-D", help="Set a parameter: name=value.")] = None,
    set_file: Annotated[Path | None, _option("-p", help="OpenSCAD parameter sets (JSON).")] = None,
    set_name: Annotated[str | None, _option("-P", help="The parameter set to take from -p.")] = None,
    size: Annotated[float | None, _option(help="Edge with the quiet zone, mm.")] = None,
    thickness: Annotated[float | None, _option(help="Thickness, mm.")] = None,
    nozzle: Annotated[float | None, _option(help="Nozzle or kerf width, mm.")] = None,
    level: Annotated[_Level | None, _option(help="Error correction level.")] = None,
    version: Annotated[int | None, _option(help="Symbol version, 1-40.")] = None,
    pressure: Annotated[float | None, _option(help="Pressure on the part, MPa.")] = None,
    finger: Annotated[float | None, _option(help="A fingertip's force at the worst place, N.")] = None,
    own_weight: Annotated[
        bool, _option("--own-weight", help="The part lies flat, held by its supports.")
    ] = False,
    support: Annotated[str | None, _option(help="clamped, simple, two-sides or corners.")] = None,
    verify_solid: Annotated[
        bool, _option("--verify-solid", help="Check the strength once more in three dimensions.")
    ] = False,
    yield_: Annotated[float | None, _option("--yield", help="Yield stress, MPa.")] = None,
    material: Annotated[str | None, _option(help="PLA, PETG, steel, ...: see params.")] = None,
    draft: Annotated[float | None, _option(help="Flare of hole walls, degrees.")] = None,
    lip: Annotated[float | None, _option(help="Straight lip before the flare, mm.")] = None,
    depth: Annotated[float | None, _option(help="Depth of blind pockets, mm; else through.")] = None,
    fillet: Annotated[float | None, _option(help="Radius of re-entrant corners, mm.")] = None,
    style: Annotated[str | None, _option(help="square, rounded, dots, ...: see params.")] = None,
    frame: Annotated[float | None, _option(help="Frame around the quiet zone, mm.")] = None,
    corner_radius: Annotated[float | None, _option(help="Radius of the outer corners, mm.")] = None,
    hole: Annotated[
        list[str] | None, _option(help="Mounting holes in the frame: D (corners) or X,Y,D. Repeats.")
    ] = None,
    caption: Annotated[
        str | None, _option("--caption", "--text", help="Text on the frame; may have several lines.")
    ] = None,
    caption_place: Annotated[str | None, _option(help="bottom or top: below or above the code.")] = None,
    font: Annotated[str | None, _option(help="Of the caption: an installed font's name, or a file.")] = None,
    backing: Annotated[float | None, _option(help="Thickness of a plate behind, mm.")] = None,
    gap: Annotated[float | None, _option(help="Gap before that plate, mm.")] = None,
    finder: Annotated[str | None, _option(help="Bars of the finder rings: see params.")] = None,
    objective: Annotated[str | None, _option(help="optimal, or the paper's: paper.")] = None,
    quiet: Annotated[int | None, _option(help="Light margin around the code, modules.")] = None,
    tone: Annotated[str | None, _option(help="normal (light is material) or inverted.")] = None,
    colour: Annotated[str | None, _option(help="Colour of the part: a name or #rrggbb.")] = None,
    ground: Annotated[str | None, _option(help="Colour behind it: a name or #rrggbb.")] = None,
    scan_tilt: Annotated[float | None, _option(help="Tilt at which it must read, degrees.")] = None,
    seed: Annotated[int | None, _option(help="Seed of everything random.")] = None,
    as_json: _Json = False,
) -> None:
    """Make a part from a text or a picture, and write it with its certificate."""
    from perfqr_cad import catalog, export

    if text is not None and image is not None:
        raise DesignError("a text and --image are both given: give one of them")
    outputs = output or []
    if not outputs and not as_json:
        raise DesignError("nothing to write: give -o FILE, -o FOLDER/ or --json")
    chosen = catalog.find(template)
    sets = catalog.read_parameter_set(set_file, set_name or "") if set_file else {}
    defined = dict(catalog.read_definition(d) for d in define or [])
    values = chosen.values(catalog.merge(sets, defined, _settings(context)))
    export.check(outputs)
    with _progress():
        design = chosen.build(values).written(outputs)
    if as_json:
        _print_json(design.certificate())
    else:
        typer.echo(design.summary())


def _settings(context: typer.Context) -> dict[str, Value]:
    """The options of `make` that were given, by the names that templates have for them."""
    given: dict[str, Value] = {}
    for name, value in context.params.items():
        match value:
            case None | False | [] | ():
                continue
            case _ if name in NOT_OF_TEMPLATES:
                continue
            case list() | tuple():
                given[name] = "; ".join(value)
            case Path() | StrEnum():
                given[name] = str(value)
            case _:
                given[name.rstrip("_")] = value
    return given


@app.command()
def read(picture: Annotated[Path, typer.Argument(metavar="IMAGE")], as_json: _Json = False) -> None:
    """Read a picture of a code: payload, version, level, mask, errors per block, and L(Q)."""
    from perfqr_cad.capture import read as capture
    from perfqr_cad.certificate import reading

    with _progress():
        report = reading(capture(picture))
    if as_json:
        _print_json(report)
    else:
        for name, value in report.items():
            typer.echo(f"{name}: {value}")


@app.command()
def scan(
    part: Annotated[Path, typer.Argument(help=".step, .stl, .3mf, or a design .json")],
    text: Annotated[str | None, typer.Option(help="The text that must come back.")] = None,
    as_json: _Json = False,
) -> None:
    """Film a part from many sides and let every decoder read it."""
    from perfqr_cad import design

    with _progress():
        report = design.scan_part(part, text)
    if as_json:
        _print_json(report.as_dict())
    else:
        typer.echo(report.render())


@app.command()
def templates(as_json: _Json = False) -> None:
    """List the shipped templates."""
    from perfqr_cad import catalog

    found = catalog.available()
    if as_json:
        _print_json([{"name": t.name, "description": t.description, "path": str(t.path)} for t in found])
    for template in [] if as_json else found:
        typer.echo(f"{template.name:12} {template.description.splitlines()[0]}")


@app.command()
def params(template: _TemplateName, as_json: _Json = False) -> None:
    """List what a template lets you set."""
    from perfqr_cad import catalog

    found = catalog.find(template)
    if as_json:
        _print_json(catalog.describe(found))
    else:
        typer.echo(catalog.listing(found).render())


@app.command()
def reproduce(
    experiments: Annotated[list[str] | None, typer.Argument(help=", ".join(EXPERIMENTS))] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for pictures and tables.")] = Path(
        "out/reproduce"
    ),
    as_json: _Json = False,
) -> None:
    """Run the paper's experiments on this machine."""
    from importlib import import_module

    for name in _chosen(experiments, EXPERIMENTS):
        with _progress():
            _print_table(import_module(f"perfqr_cad.reproduce.{name}").run(output), as_json)


@app.command()
def bench(
    layers: Annotated[list[str] | None, typer.Argument(help=", ".join(BENCHMARKS))] = None,
    as_json: _Json = False,
) -> None:
    """Measure, as ratios in one run."""
    from importlib import import_module

    for name in _chosen(layers, BENCHMARKS):
        result = import_module(f"perfqr_cad.bench.{name}").run()
        for table in result if isinstance(result, tuple | list) else (result,):
            _print_table(table, as_json)


def main(arguments: list[str] | None = None) -> NoReturn:
    """Entry point of the command: run it, then exit with 0, or 2 after one line that says what is wrong."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        status = app(arguments or ["--help"], prog_name="perfqr", standalone_mode=False)
    except (PerfQRError, typer.TyperException) as error:
        message = error.format_message() if isinstance(error, typer.TyperException) else str(error)
        typer.echo("error: " + " ".join(message.split()), err=True)
        status = BAD_INPUT
    except (typer.Abort, KeyboardInterrupt):
        status = INTERRUPTED
    sys.exit(status or 0)


def _version(show: bool) -> None:
    if show:
        typer.echo(f"perfqr {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True)] = False,
) -> None:
    del version


@contextlib.contextmanager
def _progress() -> Generator[None]:
    """A spinner with the running step on standard error, when that is a terminal."""
    from perfqr_cad import progress

    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status("starting") as status, progress.listening(status.update):
        yield


def _chosen(names: list[str] | None, known: tuple[str, ...]) -> tuple[str, ...]:
    for name in names or []:
        if name not in known:
            raise DesignError(f"{name!r} is not one of {', '.join(known)}")
    return tuple(names) if names else known


def _print_table(table: Table, as_json: bool) -> None:
    if as_json:
        _print_json(table.as_dict())
    else:
        typer.echo(table.render() + "\n")


def _print_json(value: Any) -> None:
    typer.echo(json.dumps(value, indent=2, ensure_ascii=False))
