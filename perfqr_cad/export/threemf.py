"""3MF, core specification 1.3: one printable object; with a backing, two coloured parts of one object."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape, quoteattr

from perfqr_cad.export.design_view import DesignView

if TYPE_CHECKING:
    from perfqr_cad.solid import Solid

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
MODEL_PART = "3D/3dmodel.model"
ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest time a zip can hold: the same bytes whenever written
MATERIALS_ID = 1

CONTENT_TYPES = f"""<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="{PACKAGE}/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
RELATIONSHIPS = f"""<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="{PACKAGE}/relationships">
<Relationship Target="/{MODEL_PART}" Id="model" \
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""


def write(design: DesignView, path: Path) -> None:
    """Write the part, and its backing where there is one, each with its own material."""
    with zipfile.ZipFile(path, "w") as package:
        for name, text in (
            ("[Content_Types].xml", CONTENT_TYPES),
            ("_rels/.rels", RELATIONSHIPS),
            (MODEL_PART, _model(design.solid.name, [design.solid, *design.solid.extras])),
        ):
            info = zipfile.ZipInfo(name, ZIP_EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            package.writestr(info, text)


def _model(name: str, bodies: list[Solid]) -> str:
    first = MATERIALS_ID + 1
    objects = "".join(_object(first + i, i, body) for i, body in enumerate(bodies))
    item = first
    if len(bodies) > 1:
        item = first + len(bodies)
        parts = "".join(f'<component objectid="{first + i}"/>\n' for i in range(len(bodies)))
        objects += (
            f'<object id="{item}" type="model" name={quoteattr(name)}>\n'
            f"<components>\n{parts}</components>\n</object>\n"
        )
    materials = "".join(map(_material, bodies))
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<model unit="millimeter" xml:lang="en" xmlns="{CORE}">\n'
        f'<metadata name="Title">{escape(name)}</metadata>\n'
        f'<resources>\n<basematerials id="{MATERIALS_ID}">\n{materials}</basematerials>\n'
        f"{objects}</resources>\n"
        f'<build>\n<item objectid="{item}"/>\n</build>\n</model>\n'
    )


def _material(body: Solid) -> str:
    colour = "".join(f"{round(255 * part):02X}" for part in body.colour)
    return f'<base name={quoteattr(body.name)} displaycolor="#{colour}"/>\n'


def _object(number: int, material: int, body: Solid) -> str:
    points, corners = body.triangles.vertices.tolist(), body.triangles.faces.tolist()
    vertices = "\n".join(f'<vertex x="{x:.7g}" y="{y:.7g}" z="{z:.7g}"/>' for x, y, z in points)
    faces = "\n".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in corners)
    return (
        f'<object id="{number}" type="model" name={quoteattr(body.name)} '
        f'pid="{MATERIALS_ID}" pindex="{material}">\n'
        f"<mesh>\n<vertices>\n{vertices}\n</vertices>\n<triangles>\n{faces}\n</triangles>\n</mesh>\n</object>\n"
    )
