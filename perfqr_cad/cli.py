"""The command `perfqr`: parse, call, print. No logic.

Figures and JSON go to standard output, progress and errors to standard error. Bad input ends with one
line (value, limit, remedy) and exit code 2.
"""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from perfqr_cad import __version__, scratch, setting_options, supervised
from perfqr_cad.errors import DesignError, NotHeldError, PerfQRError

if TYPE_CHECKING:
    from perfqr_cad.batch.making import Outcome
    from perfqr_cad.table import Table

app = typer.Typer(
    name="perfqr",
    help="Perforated QR codes as real parts: one piece, strong enough, and proven to scan.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # rich help costs 0.15 s of imports at every start
)

BENCHMARKS = (
    "symbol",
    "capture",
    "pattern",
    "freedom",
    "finder",
    "margin",
    "structure",
    "solid",
    "scan",
    "spine",
)
# Exit codes; 130 is the shell's own for an interrupt.
NOT_HELD, ROWS_MISSING, INTERRUPTED = 3, 4, 130
EXPERIMENTS = ("table1", "table2", "fig9", "fig11", "fig14", "colours", "materials", "limits", "bunny")


def _option(*names: str, help: str) -> Any:
    return typer.Option(*names, help=help)


_Json = Annotated[bool, _option("--json", help="Print JSON on standard output.")]
_TemplateName = Annotated[str, typer.Argument(help="A template's name or a .py file.")]


@app.command(cls=setting_options.Grouped)
@setting_options.with_settings
def make(
    context: typer.Context,
    payload: Annotated[str | None, typer.Argument(metavar="TEXT", help="The text of the code.")] = None,
    output: Annotated[
        list[str] | None, _option("-o", "--output", help="FILE (suffix = format) or FOLDER/ (all). Repeats.")
    ] = None,
    template: Annotated[str, _option("-t", "--template", help="A template or a .py file.")] = "plate",
    define: Annotated[list[str] | None, _option("-D", help="Set a parameter: name=value. Repeats.")] = None,
    set_file: Annotated[Path | None, _option("-p", help="OpenSCAD parameter sets (JSON).")] = None,
    set_name: Annotated[str | None, _option("-P", help="The parameter set to take from -p.")] = None,
    template_timeout: Annotated[
        float, _option("--template-timeout", help="Seconds that a template's own code may compute, or wait.")
    ] = 60.0,
    as_json: _Json = False,
    **_: Any,
) -> None:
    """Make a part from a text or a picture, and write it with its certificate.

    An option is the parameter of the same name in a template: --size 40 is -D size=40.
    """
    from perfqr_cad import catalog, export
    from perfqr_cad.pipeline.effect import require_files

    outputs = output or []
    if not outputs and not as_json:
        raise DesignError("nothing to write: give -o FILE, -o FOLDER/ or --json")
    if (set_file is None) != (set_name is None):
        given, missing = ("-P", "-p FILE") if set_file is None else ("-p", "-P NAME")
        raise DesignError(f"{given} names a parameter set only together with {missing}: give both")
    chosen = catalog.find(template)
    sets = catalog.read_parameter_set(set_file, set_name) if set_file and set_name is not None else {}
    explicit = setting_options.joined(
        catalog.read_definitions(define or []), setting_options.given(context.params, payload)
    )
    values = chosen.values(setting_options.over(sets, explicit))
    require_files(chosen.parameters, values, export.check(outputs))
    with _progress():
        design = chosen.build(values, timeout_s=template_timeout).written(outputs)
    if as_json:
        _print_json(design.certificate())
    else:
        typer.echo(design.summary())


@app.command(cls=setting_options.Grouped)
@setting_options.with_settings
def batch(
    context: typer.Context,
    table: Annotated[Path, typer.Argument(help="CSV: a row for each part, a column for each setting.")],
    output: Annotated[Path, _option("-o", "--output", help="Folder of all files.")],
    template: Annotated[str, _option("-t", "--template", help="A template or a .py file.")] = "plate",
    define: Annotated[list[str] | None, _option("-D", help="A parameter for all rows: name=value.")] = None,
    pattern: Annotated[
        str | None, _option("--name", help="Names of files: {column} and {row}; else the column name.")
    ] = None,
    files: Annotated[str, _option("--files", help="Formats for each row, with commas between.")] = "stl,json",
    lines: Annotated[bool, _option("--lines", help="The table is a plain list: a text a line.")] = False,
    jobs: Annotated[int, _option("--jobs", help="Processes that work at the same time.")] = 1,
    scheduler: Annotated[
        str | None, _option("--scheduler", help="Address of a Dask scheduler whose workers do it.")
    ] = None,
    template_timeout: Annotated[
        float, _option("--template-timeout", help="CPU seconds that a template's own code may take.")
    ] = 60.0,
    as_json: _Json = False,
    **_: Any,
) -> None:
    """Make a part of every row of a table. Rows that are there already are kept; options hold for all rows.

    In the texts of options, {column} stands for the row's cell.
    """
    from perfqr_cad import batch as batches
    from perfqr_cad import catalog

    shared = setting_options.joined(
        catalog.read_definitions(define or []), setting_options.given(context.params, None)
    )
    plan = batches.Plan(
        catalog.find(template), shared, output, pattern, batches.suffixes(files), template_timeout
    )
    rows = batches.read_lines(table) if lines else batches.read_table(table)
    made = batches.run(plan, rows, jobs=jobs, scheduler=scheduler, told=_tell_row)
    if as_json:
        _print_json([outcome.as_dict() for outcome in made.outcomes])
    else:
        typer.echo(f"{made.words}: {made.path}")
    if not made.complete:
        raise typer.Exit(ROWS_MISSING)


@app.command()
def read(
    picture: Annotated[Path, typer.Argument(metavar="IMAGE")],
    which: Annotated[int | None, typer.Option(help="Which of several codes in it, from 1.")] = None,
    as_json: _Json = False,
) -> None:
    """Read a picture of a code: payload, version, level, mask, errors per block, and L(Q)."""
    from perfqr_cad.capture import read as capture
    from perfqr_cad.pipeline.certificate import reading

    with _progress():
        report = reading(capture(picture, which))
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
    from perfqr_cad.pipeline.chain import scan_part

    with _progress():
        report = scan_part(part, text)
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
def params(
    template: _TemplateName,
    as_json: _Json = False,
    as_schema: Annotated[bool, _option("--schema", help="Print a JSON Schema of the parameters.")] = False,
) -> None:
    """List what a template lets you set."""
    from perfqr_cad import catalog

    found = catalog.find(template)
    if as_schema:
        _print_json(catalog.schema(found))
    elif as_json:
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
        status = NOT_HELD if isinstance(error, NotHeldError) else supervised.BAD_INPUT
    except (typer.Abort, KeyboardInterrupt):
        status = INTERRUPTED
    sys.exit(status or 0)


def entry() -> NoReturn:
    """The command as a program: `main` in a process of its own, which a signal n ends with 128 + n."""
    scratch.sweep()
    sys.exit(supervised.run(_status))


def _status() -> int:
    try:
        main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 1


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


def _tell_row(outcome: Outcome) -> None:
    """A line on standard error for each finished row."""
    told = outcome.note or outcome.readers
    typer.echo(f"row {outcome.number} {outcome.name}: {outcome.status}{', ' if told else ''}{told}", err=True)


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
