"""Templates: parametric parts that a user can list, set and run without writing code.

A template's parameters are read from its source; only `build(p)` is run. Nothing here designs a part.
"""

from perfqr_cad.catalog.parameter import Parameter, Value
from perfqr_cad.catalog.templates import (
    Template,
    available,
    describe,
    find,
    listing,
    load,
    merge,
    read_definition,
    read_parameter_set,
)

__all__ = [
    "Parameter",
    "Template",
    "Value",
    "available",
    "describe",
    "find",
    "listing",
    "load",
    "merge",
    "read_definition",
    "read_parameter_set",
]
