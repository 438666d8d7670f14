"""3MF, core specification 1.3 with the colours of its materials extension: one printable object.

A part with a backing is one mesh of two shells. PrusaSlicer makes the components of an object into objects of
their own and lays them side by side; what it keeps together are ranges of one mesh, which
`Metadata/Slic3r_PE_model.config` gives a name and an extruder each. OrcaSlicer and Bambu Studio read that
list too, in files whose application names PrusaSlicer. Colours by triangle say the same to programs that read
the standard alone. Nothing lies below z = 0, where printers have their bed.

For printers with one nozzle the bodies are one volume, and a list says from which height on each is printed.
"""

from __future__ import annotations

import zipfile
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape, quoteattr

from perfqr_cad import __version__
from perfqr_cad.export.colour_change import ColourChange, colour_changes, hexadecimal
from perfqr_cad.export.design_view import DesignView

if TYPE_CHECKING:
    from perfqr_cad.solid import Solid

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
COLOURS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
MODEL_PART, EXTRUDERS_PART = "3D/3dmodel.model", "Metadata/Slic3r_PE_model.config"
CHANGES_PART = "Metadata/Prusa_Slicer_custom_gcode_per_print_z.xml"
# OrcaSlicer and Bambu Studio look for the last word, and then read the lists as PrusaSlicer does.
APPLICATION = f"perfqr-cad {__version__}, parts listed as by PrusaSlicer"
COLOUR_CHANGE, CHANGE_GCODE = 0, "M600"  # PrusaSlicer's kind of a stop for another filament; Marlin's command
# A change stands before the layer that reaches its height, and the lower body ends with a layer there.
ABOVE_MM = 0.01
ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time a zip can hold: the same bytes whenever written
MATERIALS_ID, OBJECT_ID, FIRST_COLOUR_ID = 1, 2, 3

CONTENT_TYPES = f"""<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="{PACKAGE}/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
<Default Extension="config" ContentType="application/xml"/>
<Default Extension="xml" ContentType="application/xml"/>
</Types>
"""
RELATIONSHIPS = f"""<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="{PACKAGE}/relationships">
<Relationship Target="/{MODEL_PART}" Id="model" \
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""


def write(design: DesignView, path: Path, *, colour_change: bool = False) -> None:
    """Write the part, and its backing where there is one, each with its own material and extruder.

    `colour_change`: for one nozzle that stops between two layers instead. Raises `DesignError` where the
    bodies do not lie one upon the other.
    """
    name, bodies = design.solid.name, [design.solid, *design.solid.extras]
    changes = colour_changes(design.solid) if colour_change else ()
    texts = {
        "[Content_Types].xml": CONTENT_TYPES,
        "_rels/.rels": RELATIONSHIPS,
        MODEL_PART: _model(name, bodies),
    }
    if changes:
        texts[CHANGES_PART] = _changes(changes)
    elif len(bodies) > 1:
        texts[EXTRUDERS_PART] = _extruders(name, bodies)
    with zipfile.ZipFile(path, "w") as package:
        for part, text in texts.items():
            info = zipfile.ZipInfo(part, ZIP_EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            package.writestr(info, text)


def _model(name: str, bodies: list[Solid]) -> str:
    materials = "".join(
        f'<base name={quoteattr(body.name)} displaycolor="{hexadecimal(body.colour)}"/>\n' for body in bodies
    )
    application = f'<metadata name="Application">{APPLICATION}</metadata>\n' if len(bodies) > 1 else ""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<model unit="millimeter" xml:lang="en" xmlns="{CORE}" xmlns:m="{COLOURS}">\n'
        f'<metadata name="Title">{escape(name)}</metadata>\n{application}'
        f'<resources>\n<basematerials id="{MATERIALS_ID}">\n{materials}</basematerials>\n'
        f"{_colour_groups(bodies) if len(bodies) > 1 else ''}{_object(name, bodies)}</resources>\n"
        f'<build>\n<item objectid="{OBJECT_ID}"/>\n</build>\n</model>\n'
    )


def _colour_groups(bodies: list[Solid]) -> str:
    """A group for every body: of a group with several colours Bambu Studio takes the last."""
    return "".join(
        f'<m:colorgroup id="{FIRST_COLOUR_ID + k}">\n<m:color color="{hexadecimal(body.colour)}FF"/>\n'
        "</m:colorgroup>\n"
        for k, body in enumerate(bodies)
    )


def _object(name: str, bodies: list[Solid]) -> str:
    """One mesh, body after body; with several each triangle names its colour."""
    lowest = min(float(body.triangles.vertices[:, 2].min()) for body in bodies)
    lift = [0.0, 0.0, max(-lowest, 0.0)]
    vertices, faces = list[str](), list[str]()
    for k, body in enumerate(bodies):
        colour = f' pid="{FIRST_COLOUR_ID + k}" p1="0"' if len(bodies) > 1 else ""
        corners = (body.triangles.faces + len(vertices)).tolist()
        points = (body.triangles.vertices + lift).tolist()
        faces += [f'<triangle v1="{a}" v2="{b}" v3="{c}"{colour}/>\n' for a, b, c in corners]
        vertices += [f'<vertex x="{x:.7g}" y="{y:.7g}" z="{z:.7g}"/>\n' for x, y, z in points]
    return (
        f'<object id="{OBJECT_ID}" type="model" name={quoteattr(name)} pid="{MATERIALS_ID}" pindex="0">\n'
        f"<mesh>\n<vertices>\n{''.join(vertices)}</vertices>\n"
        f"<triangles>\n{''.join(faces)}</triangles>\n</mesh>\n</object>\n"
    )


def _extruders(name: str, bodies: list[Solid]) -> str:
    """What PrusaSlicer reads: which triangles are which body, and the extruder that prints them."""
    ends = list(accumulate((len(body.triangles.faces) for body in bodies), initial=0))
    volumes = "".join(
        f'<volume firstid="{ends[k]}" lastid="{ends[k + 1] - 1}">\n'
        f'<metadata type="volume" key="name" value={quoteattr(body.name)}/>\n'
        '<metadata type="volume" key="volume_type" value="ModelPart"/>\n'
        f'<metadata type="volume" key="extruder" value="{k + 1}"/>\n'
        "</volume>\n"
        for k, body in enumerate(bodies)
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<config>\n'
        f'<object id="{OBJECT_ID}" instances_count="1">\n'
        f'<metadata type="object" key="name" value={quoteattr(name)}/>\n'
        f"{volumes}</object>\n</config>\n"
    )


def _changes(changes: tuple[ColourChange, ...]) -> str:
    """What PrusaSlicer reads: before which layers to stop for another filament."""
    codes = "".join(
        f'<code print_z="{change.height_mm + ABOVE_MM:.7g}" type="{COLOUR_CHANGE}" extruder="1" '
        f'color="{hexadecimal(change.colour)}" extra="" gcode="{CHANGE_GCODE}"/>\n'
        for change in changes
    )
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n<custom_gcodes_per_print_z>\n'
        f'{codes}<mode value="SingleExtruder"/>\n</custom_gcodes_per_print_z>\n'
    )
