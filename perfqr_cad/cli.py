"""The command `perfqr`: parse, call, print. No logic.

Figures and JSON go to standard output, progress and errors to standard error. Bad input ends with one
line (value, limit, remedy) and exit code 2.
"""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, Optional

import typer

from perfqr_cad import __version__
from perfqr_cad.errors import PerfQRError

if TYPE_CHECKING:
    from perfqr_cad.table import Table
    from perfqr_cad.catalog import Value

app = typer.Typer(
    name="perfqr",
    help="Perforated QR codes as real parts: one piece, strong enough, and proven to scan.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

BENCHMARKS = ("symbol", "capture", "pattern", "structure", "solid", "scan", "spine")
EXPERIMENTS = ("table1", "table2", "fig9", "fig11", "fig14", "colours", "materials", "limits", "bunny")


class _Level(str, Enum):
    L = "L"
    M = "M"
    Q = "Q"
    H = "H"


# Each common setting is one long option here and the parameter of the same name in a template.
_Size = Annotated[Optional[float], typer.Option(help="Edge of the code with its quiet zone, mm.")]
_Json = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]


@app.command()
def make(
    text: Annotated[Optional[str], typer.Argument(help="The text of the code.")] = None,
    image: Annotated[Optional[Path], typer.Option(help="A picture of an artistic code, instead of a text.")] = None,
    output: Annotated[
        Optional[list[str]],
        typer.Option("-o", "--output", help="FILE (its suffix is the format) or FOLDER/ (everything). May repeat."),
    ] = None,
    template: Annotated[str, typer.Option("-t", "--template", help="A template's name or a .py file.")] = "plate",
    define: Annotated[Optional[list[str]], typer.Option("-D", help="Set a template parameter: name=value.")] = None,
    set_file: Annotated[Optional[Path], typer.Option("-p", help="OpenSCAD parameter sets (JSON).")] = None,
    set_name: Annotated[Optional[str], typer.Option("-P", help="The parameter set to take from -p.")] = None,
    size: _Size = None,
    thickness: Annotated[Optional[float], typer.Option(help="Thickness, mm.")] = None,
    nozzle: Annotated[Optional[float], typer.Option(help="Nozzle or kerf width, mm.")] = None,
    level: Annotated[Optional[_Level], typer.Option(help="Error correction level.")] = None,
    version: Annotated[Optional[int], typer.Option(help="Symbol version 1-40; smallest that fits if not given.")] = None,
    pressure: Annotated[Optional[float], typer.Option(help="Pressure on the part, MPa.")] = None,
    yield_: Annotated[Optional[float], typer.Option("--yield", help="Yield stress, MPa; the material's if not given.")] = None,
    material: Annotated[Optional[str], typer.Option(help="PLA, PETG, ABS, PA12, resin, aluminium, steel, stainless.")] = None,
    draft: Annotated[Optional[float], typer.Option(help="Flare of the hole walls towards the back, degrees.")] = None,
    lip: Annotated[Optional[float], typer.Option(help="Straight lip at the front of flared walls, mm.")] = None,
    fillet: Annotated[Optional[float], typer.Option(help="Radius of re-entrant corners, mm.")] = None,
    style: Annotated[Optional[str], typer.Option(help="square, rounded, dots, diamond, bars.")] = None,
    tone: Annotated[Optional[str], typer.Option(help="normal (light is material) or inverted.")] = None,
    scan_tilt: Annotated[Optional[float], typer.Option(help="Tilt at which the part must still read, degrees.")] = None,
    seed: Annotated[Optional[int], typer.Option(help="Seed of everything random.")] = None,
    as_json: _Json = False,
) -> None:
    """Make a part from a text or a picture, and write it with its certificate."""
    from perfqr_cad import catalog, export

    options: dict[str, Value] = {
        "text": text, "image": None if image is None else str(image), "size": size, "thickness": thickness,
        "nozzle": nozzle, "level": None if level is None else level.value, "version": version,
        "pressure": pressure, "yield": yield_, "material": material, "draft": draft, "lip": lip,
        "fillet": fillet, "style": style, "tone": tone, "scan_tilt": scan_tilt, "seed": seed,
    }  # fmt: skip
    with _one_line_errors():
        chosen = catalog.find(template)
        values = catalog.merge(
            catalog.read_parameter_set(set_file, set_name) if set_file else {},
            dict(catalog.read_definition(d) for d in define or []),
            {name: value for name, value in options.items() if value is not None},
        )
        targets = [export.Destination.parse(o) for o in output or []]
        if not targets and not as_json:
            typer.echo("nothing to write: give -o FILE, -o FOLDER/ or --json", err=True)
            raise typer.Exit(2)
        with _progress():
            design = chosen.build(values)
            design = design.write_to(targets)
    if as_json:
        _print_json(design.certificate())
    else:
        typer.echo(design.summary())


@app.command()
def read(picture: Annotated[Path, typer.Argument(metavar="IMAGE")], as_json: _Json = False) -> None:
    """Read a picture of a code: payload, version, level, mask, errors per block, and L(Q)."""
    from perfqr_cad import design

    with _one_line_errors(), _progress():
        report = design.reading(picture)
    if as_json:
        _print_json(report)
    else:
        for name, value in report.items():
            typer.echo(f"{name}: {value}")


@app.command()
def scan(
    part: Annotated[Path, typer.Argument(help=".step, .stl, .3mf, or a design .json")],
    text: Annotated[Optional[str], typer.Option(help="The text that must come back.")] = None,
    as_json: _Json = False,
) -> None:
    """Film a part from many sides and let every decoder read it."""
    from perfqr_cad import design

    with _one_line_errors(), _progress():
        report = design.scan_part(part, text)
    if as_json:
        _print_json(report.as_dict())
    else:
        typer.echo(report.render())


@app.command()
def templates(as_json: _Json = False) -> None:
    """List the shipped templates."""
    from perfqr_cad import catalog

    with _one_line_errors():
        found = catalog.available()
    if as_json:
        _print_json([{"name": t.name, "description": t.description, "path": str(t.path)} for t in found])
    for template in [] if as_json else found:
        typer.echo(f"{template.name:12} {template.description.splitlines()[0]}")


@app.command()
def params(template: Annotated[str, typer.Argument(help="A template's name or a .py file.")], as_json: _Json = False) -> None:
    """List what a template lets you set."""
    from perfqr_cad import catalog

    with _one_line_errors():
        found = catalog.find(template)
    if as_json:
        _print_json(catalog.describe(found))
    else:
        typer.echo(catalog.listing(found).render())


@app.command()
def reproduce(
    experiments: Annotated[Optional[list[str]], typer.Argument(help=f"Any of {', '.join(EXPERIMENTS)}; all if none.")] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for pictures and tables.")] = Path("out/reproduce"),
    as_json: _Json = False,
) -> None:
    """Run the paper's experiments on this machine."""
    from importlib import import_module

    with _one_line_errors():
        for name in _chosen(experiments, EXPERIMENTS):
            with _progress():
                _print_table(import_module(f"perfqr_cad.reproduce.{name}").run(output), as_json)


@app.command()
def bench(
    layers: Annotated[Optional[list[str]], typer.Argument(help=f"Any of {', '.join(BENCHMARKS)}; all if none.")] = None,
    as_json: _Json = False,
) -> None:
    """Measure, as ratios in one run."""
    from importlib import import_module

    with _one_line_errors():
        for name in _chosen(layers, BENCHMARKS):
            result = import_module(f"perfqr_cad.bench.{name}").run()
            for table in result if isinstance(result, tuple | list) else (result,):
                _print_table(table, as_json)


def main() -> None:
    """Entry point of the command."""
    app(prog_name="perfqr")


def _version(show: bool) -> None:
    if show:
        typer.echo(f"perfqr {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")] = False,
) -> None:
    del version


@contextlib.contextmanager
def _one_line_errors() -> Iterator[None]:
    try:
        yield
    except PerfQRError as error:
        _fail(str(error))


def _fail(message: str) -> NoReturn:
    typer.echo("error: " + " ".join(message.split()), err=True)
    raise typer.Exit(2)


@contextlib.contextmanager
def _progress() -> Iterator[None]:
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
            _fail(f"{name!r} is not one of {', '.join(known)}")
    return tuple(names) if names else known


def _print_table(table: Table, as_json: bool) -> None:
    if as_json:
        _print_json(table.as_dict())
    else:
        typer.echo(table.render() + "\n")


def _print_json(value: Any) -> None:
    typer.echo(json.dumps(value, indent=2, ensure_ascii=False))
