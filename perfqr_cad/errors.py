"""The exception tree.

Every error this package raises on purpose is a `PerfQRError`. Its message is one line that states the
value, the limit and the remedy; the command line prints it and exits 2, or 3 for `NotHeldError`.
Remedies are made in `remedy`.

    PerfQRError
    ├── SymbolError      text that does not fit, a matrix damaged beyond its capacity
    ├── CaptureError     a file that is no picture, a picture without a code
    ├── DesignError      a size, web, style or setting that cannot be made
    │   └── NotHeldError what was asked for by name, and the finished part does not hold
    │       ├── WeakError    it breaks under the load
    │       └── UnreadError  decoders do not read it
    ├── KernelError      the solid modeller could not build, read or write a shape
    ├── AnalysisError    a strength model that has no answer
    └── TemplateError    a template, parameter or parameter set that cannot be used
"""

from __future__ import annotations

from perfqr_cad.remedy import Remedy, advice


class PerfQRError(Exception):
    """Base of all errors of this package.

    Remedies, by subclass: shorten the text or raise the version (`SymbolError`); take a sharper,
    straighter or larger picture (`CaptureError`); enlarge `--size` or use a finer nozzle
    (`DesignError`); change the wall thickness, draft or placement (`KernelError`); support the part
    or give it a thickness (`AnalysisError`); check the parameter's name and range (`TemplateError`).

    >>> error = DesignError("size 9 mm is too small", Remedy(size_mm=24.2), "a finer nozzle")
    >>> print(error, [remedy.changes for remedy in error.remedies])
    size 9 mm is too small: use --size 24.2 or a finer nozzle [{'size_mm': 24.2}]
    """

    def __init__(self, problem: str, *remedies: Remedy | str) -> None:
        super().__init__(f"{problem}: {advice(remedies)}" if remedies else problem)
        self.remedies = tuple(remedy for remedy in remedies if isinstance(remedy, Remedy))


class SymbolError(PerfQRError):
    """The text, level and version do not make a symbol, or a matrix cannot be corrected."""


class CaptureError(PerfQRError):
    """A picture could not be opened, or no QR code could be found in it."""


class DesignError(PerfQRError):
    """The settings do not make a part that can be manufactured or read."""


class NotHeldError(DesignError):
    """The part was made, but does not bear, or is not read, as was asked for by name; nothing is written.

    Its message names a change with which it does, or the option that accepts the part as it is.
    """


class WeakError(NotHeldError):
    """The part breaks under a load that was asked for."""


class UnreadError(NotHeldError):
    """Decoders do not read the part, or not from as far aside as was asked."""


class KernelError(PerfQRError):
    """A solid could not be built, checked, read or written."""


class AnalysisError(PerfQRError):
    """The strength of a part could not be computed."""


class TemplateError(PerfQRError):
    """A template or its parameters are missing, malformed or out of range."""
