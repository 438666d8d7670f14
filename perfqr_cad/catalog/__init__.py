"""Templates: parametric parts that a user can list, set and run without writing code.

A template's parameters are read from its source; only `build(p)` is run. Nothing here designs a part.
"""

from perfqr_cad.catalog.reference import describe, listing, schema
from perfqr_cad.catalog.sets import read_definition, read_definitions, read_parameter_set
from perfqr_cad.catalog.templates import Template, available, find, load
from perfqr_cad.pipeline.kinds import Value
from perfqr_cad.pipeline.parameter import Parameter

__all__ = [
    "Parameter",
    "Template",
    "Value",
    "available",
    "describe",
    "find",
    "listing",
    "load",
    "read_definition",
    "read_definitions",
    "read_parameter_set",
    "schema",
]
