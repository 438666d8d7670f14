"""Parts on their way between processes: the modeller's own binary form, names and colours beside it."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from OCP.BinTools import BinTools
from OCP.BRep import BRep_Builder
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Iterator, TopoDS_Shape, TopoDS_Solid

from perfqr_cad.isolated import Message
from perfqr_cad.profile.colour import Colour


@dataclass(frozen=True)
class StepPart:
    """A solid of a STEP file, in mm where the assembly puts it, with its product's name and its colour."""

    shape: TopoDS_Solid
    name: str
    colour: Colour | None


def packed(parts: Sequence[StepPart]) -> Message:
    """Parts as a message, with the triangles that they have been given. What they share stays shared."""
    builder, together = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(together)
    for part in parts:
        builder.Add(together, part.shape)
    stream = io.BytesIO()
    BinTools.Write_s(together, stream)
    names = [(part.name, part.colour) for part in parts]
    return Message(names, (np.frombuffer(stream.getbuffer(), np.uint8),))


def unpacked(message: Message) -> tuple[StepPart, ...]:
    """The parts of a message."""
    together = TopoDS_Shape()
    BinTools.Read_s(together, io.BytesIO(message.arrays[0].tobytes()))
    each, parts = TopoDS_Iterator(together), list[StepPart]()
    for name, colour in message.value:
        parts.append(StepPart(TopoDS.Solid_s(each.Value()), name, None if colour is None else tuple(colour)))
        each.Next()
    return tuple(parts)
