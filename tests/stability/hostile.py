"""Small files that crash, never end or take all memory where they are read as they come: one maker each.

Nothing here is large on the disk.
"""

from __future__ import annotations

import gzip
import io
import json
import random
import struct
import zipfile
import zlib

import numpy as np
from PIL import Image

NOISE = random.Random(1).randbytes(5000)


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width: int, height: int, pixels: bytes, *, more: bytes = b"", depth: int = 8, kind: int = 0) -> bytes:
    """A PNG of these figures; whether its packed pixels fit them is up to the caller."""
    header = _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + more + _chunk(b"IDAT", pixels) + _chunk(b"IEND", b"")


def _saved(kind: str, **settings: object) -> bytes:
    target = io.BytesIO()
    Image.new("RGB", (60, 60), "white").save(target, kind, **settings)
    return target.getvalue()


def _bomb(text: bytes) -> bytes:
    """64 MB of one letter, packed."""
    return text + zlib.compress(b"A" * (64 << 20), 9)


def many_scans() -> bytes:
    """A progressive JPEG whose last scan is repeated: each costs a look at every one of its pixels."""
    target = io.BytesIO()
    Image.new("L", (8000, 8000)).save(target, "JPEG", progressive=True)
    whole = target.getvalue()
    last = whole.rindex(b"\xff\xda")
    return whole[:last] + whole[last:-2] * 4000 + b"\xff\xd9"


PICTURES: dict[str, bytes] = {
    "empty.png": b"",
    "noise.png": NOISE,
    "cut.png": _saved("PNG")[:60],
    "cut.jpg": _saved("JPEG")[:200],
    "claims.png": png(50_000, 50_000, zlib.compress(b"\0" * 10)),
    "thin.png": png(90_000_000, 1, zlib.compress(b"\0" * 10)),
    "strip.png": png(4_000_000, 21, zlib.compress(b"\0" * 10)),
    "text.png": png(60, 60, zlib.compress(b"\0" * 61 * 60), more=_chunk(b"zTXt", _bomb(b"k\0\0"))),
    "profile.png": png(60, 60, zlib.compress(b"\0" * 61 * 60), more=_chunk(b"iCCP", _bomb(b"k\0\0"))),
    "cut.webp": _saved("WEBP")[:30],
    "cut.tif": _saved("TIFF")[:100],
    "loop.tif": b"II*\0\x08\0\0\0\x01\0\0\1\3\0\1\0\0\0\x40\0\0\0\x08\0\0\0",
    "script.eps": b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 99 99\n{} loop\n",
    "page.pdf": b"%PDF-1.4\n",
}


def svg(body: str, head: str = "", box: str = "0 0 100 100") -> bytes:
    """A drawing."""
    return (
        f'<?xml version="1.0"?>{head}<svg xmlns="http://www.w3.org/2000/svg" '
        f'xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="{box}">{body}</svg>'
    ).encode()


def laughs(document: str) -> str:
    """Entities of entities."""
    links = "".join(f"<!ENTITY a{k} '{f'&a{k - 1};' * 10}'>" for k in range(1, 10))
    return f"<!DOCTYPE {document} [<!ENTITY a0 'ha'>{links}]>"


def _filter(primitive: str) -> bytes:
    return svg(f"<filter id='f'>{primitive}</filter><rect width='99' height='99' filter='url(#f)'/>")


_COPIES = "".join(f"<g id='u{k}'>" + f"<use href='#u{k - 1}'/>" * 10 + "</g>" for k in range(1, 10))
DRAWINGS: dict[str, bytes] = {
    "deep.svg": svg("<g>" * 100_000 + "</g>" * 100_000),
    "many.svg": svg("<g/>" * 500_001),
    "file.svg": svg("<image width='9' height='9' href='/etc/passwd'/>"),
    "zero.svg": svg("<image width='9' height='9' xlink:href='/dev/zero'/>"),
    "url.svg": svg("<image width='9' height='9' xlink:href='http://127.0.0.1:9/a.png'/>"),
    "glow.svg": svg("<filter id='f'><feImage href='file:///dev/zero'/></filter>"),
    "relative.svg": svg("<image width='9' height='9' href=' other.png'/>"),
    "laughs.svg": svg("<text>&a9;</text>", laughs("svg")),
    "outside.svg": svg("<text>&x;</text>", '<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]>'),
    "hidden.svg": svg("&x;", "<!DOCTYPE svg [<!ENTITY x \"<image href='/dev/zero'/>\">]>"),
    "copies.svg": svg(f"<defs><g id='u0'><rect width='1' height='1'/></g>{_COPIES}</defs><use href='#u9'/>"),
    "turbulence.svg": _filter("<feTurbulence numOctaves='2000000000' baseFrequency='.9'/>"),
    "no_size.svg": b'<svg xmlns="http://www.w3.org/2000/svg"/>',
    "no_number.svg": svg("", box="0 0 nan inf"),
    "thin.svg": svg("<rect width='9' height='9'/>", box="0 0 100000 0.001"),
    "cut.svg": svg("<rect/>")[:-9],
    "packed.svgz": gzip.compress(b"<svg>" + b" " * (64 << 20), 9),
    "torn.svgz": gzip.compress(svg("<g/>" * 999))[:60],
    "flipped.svgz": b"\x1f\x8b\x08\0\0\0\0\0\0\3" + NOISE[:200],
}


def stl(*triangles: tuple[tuple[object, ...], ...]) -> bytes:
    """An ASCII STL; coordinates are written as they are."""
    facets = (
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {' '.join(map(str, corner))}\n" for corner in triangle)
        + "endloop\nendfacet\n"
        for triangle in triangles
    )
    return f"solid a\n{''.join(facets)}endsolid a\n".encode()


def _with(first: object) -> bytes:
    return stl(((0, 0, 0), (first, 0, 0), (0, 1, 0)))


def ply(vertices: int, kind: str = "ascii", face: str = "3 0 1 2") -> bytes:
    """A PLY of one triangle that claims so many vertices."""
    head = f"ply\nformat {kind} 1.0\nelement vertex {vertices}\n"
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    return f"{head}{axes}{faces}0 0 0\n1 0 0\n0 1 0\n{face}\n".encode()


def soup(count: int) -> bytes:
    """Loose triangles: a binary STL."""
    draw = np.random.default_rng(0)
    facets = np.zeros(count, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    facets["corners"] = draw.random((count, 1, 3)) + 0.1 * draw.random((count, 3, 3))
    return b"soup".ljust(80) + struct.pack("<I", count) + facets.tobytes()


THREE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
MESHES: dict[str, bytes] = {
    "empty.stl": b"",
    "noise.stl": NOISE,
    "head.stl": b"\0" * 80 + struct.pack("<I", 4_000_000_000),
    "short.stl": b"\0" * 80 + struct.pack("<I", 3) + b"\1" * 70,
    "cut.stl": _with(1)[:60],
    "nan.stl": _with("nan"),
    "inf.stl": _with("inf"),
    "word.stl": _with("abc"),
    "far.stl": _with("1e38"),
    "point.stl": stl(((0, 0, 0),) * 3),
    "empty.obj": b"",
    "range.obj": f"{THREE}f 1 2 99\n".encode(),
    "zero.obj": f"{THREE}f 0 0 0\n".encode(),
    "before.obj": b"v 0 0 0\nf -1 -2 -3\n",
    "large.obj": f"{THREE}f 1 1 99999999999999999999999\n".encode(),
    "empty.off": b"",
    "word.off": b"OFF\nhello",
    "count.off": b"OFF\n2000000000 2000000000 0\n0 0 0\n",
    "below.off": b"OFF\n-3 -1 0\n",
    "range.off": b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n",
    "empty.ply": b"",
    "endless.ply": b"ply\nformat ascii 1.0\n",
    "count.ply": ply(4_000_000_000),
    "binary.ply": ply(2_000_000_000, "binary_little_endian"),
    "range.ply": ply(3, face="3 0 1 9"),
}

TETRAHEDRON = (
    '<object id="{id}"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="60" y="0" z="0"/>'
    '<vertex x="0" y="60" z="0"/><vertex x="0" y="0" z="60"/></vertices><triangles>'
    '<triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/>'
    '<triangle v1="1" v2="2" v3="3"/></triangles></mesh></object>'
)
ONE = TETRAHEDRON.format(id=1)


def model(objects: str, build: str = '<item objectid="1"/>', head: str = "", unit: str = "millimeter") -> str:
    """The model part of a 3MF package."""
    space = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    resources = f"<resources>{objects}</resources><build>{build}</build>"
    return f'<?xml version="1.0"?>{head}<model unit="{unit}" xmlns="{space}">{resources}</model>'


def package(text: str | bytes, name: str = "3D/3dmodel.model") -> bytes:
    """A 3MF package of that model part."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, text)
    return target.getvalue()


def placed(transform: str) -> bytes:
    """A package whose object is placed so."""
    return package(model(ONE, f'<item objectid="1" transform="{transform}"/>'))


def _patched(local: int, central: int, value: int, width: int = 1) -> bytes:
    """A package whose two headers hold a value at these offsets (ZIP, §4.3.7, §4.3.12)."""
    data = bytearray(package(model(ONE)))
    for place in (local, data.find(b"PK\1\2") + central):
        data[place : place + width] = value.to_bytes(width, "little")
    return bytes(data)


def _flipped() -> bytes:
    """A package whose content does not fit its checksum."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_STORED) as archive:
        archive.writestr("3D/3dmodel.model", model(ONE))
    data = target.getvalue()
    return data.replace(b'x="60"', b'x="61"', 1)


def _powers() -> str:
    """Ten objects in an object in an object, and so on."""
    parts = (
        f'<object id="{k}"><components>{f"<component objectid={chr(34)}{k - 1}{chr(34)}/>" * 10}'
        "</components></object>"
        for k in range(1, 9)
    )
    return model(TETRAHEDRON.format(id=0) + "".join(parts), '<item objectid="8"/>')


_COMPONENT = '<object id="1"><components><component objectid="{id}"/></components></object>'
PACKAGES: dict[str, bytes] = {
    "empty.3mf": b"",
    "noise.3mf": b"PK\3\4" + NOISE[:500],
    "other.3mf": package(model(ONE), "readme.txt"),
    "claims.3mf": _patched(22, 24, 500_000_000, width=4),
    "less.3mf": _patched(22, 24, 20, width=4),
    "laughs.3mf": package(model('<object id="&a9;"/>', head=laughs("model"))),
    "itself.3mf": package(model(_COMPONENT.format(id=1))),
    "missing.3mf": package(model(_COMPONENT.format(id=7))),
    "powers.3mf": package(_powers()),
    "word.3mf": package(model(ONE.replace('x="60"', 'x="abc"'))),
    "nothing.3mf": package(model(ONE.replace('x="60"', ""))),
    "far.3mf": package(model(ONE.replace('x="60"', 'x="1e300"'))),
    "index.3mf": package(model(ONE.replace('v1="0"', 'v1="1e3"'))),
    "large.3mf": package(model(ONE.replace('v1="0"', 'v1="99999999999999999999"'))),
    "range.3mf": package(model(ONE.replace('v1="0"', 'v1="9"'))),
    "letters.3mf": placed("a b c"),
    "nan.3mf": placed("nan 0 0 0 1 0 0 0 1 0 0 0"),
    "flat.3mf": placed("0 0 0 0 0 0 0 0 0 0 0 0"),
    "unit.3mf": package(model(ONE, unit="lightyear")),
    "deep.3mf": package(model("<a>" * 200_000 + "</a>" * 200_000)),
    "cut.3mf": package(model(ONE)[:-40]),
    "encrypted.3mf": _patched(6, 8, 1),
    "method.3mf": _patched(8, 10, 97),
    "checksum.3mf": _flipped(),
}


def step(data: str) -> bytes:
    """A STEP file of that data section."""
    return (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        f"FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n"
    ).encode()


STEPS: dict[str, bytes] = {
    "empty.step": b"",
    "noise.step": NOISE,
    "cut.step": step("#1=A();")[:-30],
    "header.step": b"ISO-10303-21;\nEND-ISO-10303-21;",
    "nothing.step": step(""),
    "inside.step": b"ISO-10303-21;" + NOISE + b"END-ISO-10303-21;",
    "nested.step": step(f"#1=A({'(' * 300_000}{')' * 300_000});"),
    "open.step": step(f"#1=A({'(' * 300_000}"),
    "hidden.step": step(f"/* ' */ #1=A({'(' * 300_000}{')' * 300_000}); /* ' */"),
    "points.step": step("\n".join(f"#{k}=CARTESIAN_POINT('',(0.,0.,0.));" for k in range(1, 20_000))),
    "text.step": step(f"#1=PRODUCT('{'A' * 1_000_000}','','',());"),
    "itself.step": step("#1=CLOSED_SHELL('',(#1));#2=MANIFOLD_SOLID_BREP('',#1);"),
    "numbers.step": step("#99999999999999999999=CARTESIAN_POINT('',(1.E999,nan,0.));"),
}

SETS: dict[str, bytes] = {
    "deep.json": b'{"parameterSets":{"a":' + b"[" * 200_000 + b"]" * 200_000 + b"}}",
    "deeper.json": b'{"parameterSets":{"a":' + b'{"a":' * 100 + b"1" + b"}" * 100 + b"}}",
    "list.json": b"[]",
    "number.json": b"3",
    "null.json": b"null",
    "members.json": b'{"parameterSets": [1]}',
    "none.json": b'{"parameterSets": {"a": null}}',
    "nan.json": b'{"parameterSets": {"a": {"size": NaN}}}',
    "cut.json": b'{"parameterSets": {"a"',
    "utf16.json": json.dumps({"parameterSets": {"a": {}}}).encode("utf-16"),
    "large.json": b'{"parameterSets":{"a":{"text":"' + b"x" * 3_000_000 + b'"}}}',
}

TEMPLATES: dict[str, bytes] = {
    "nul.py": b"x=1\0\ndef build(p): pass\n",
    "latin1.py": "# -*- coding: latin-1 -*-\nx='ä'\ndef build(p): pass\n".encode("latin-1"),
    "deep.py": b"x = " + b"-" * 30_000 + b"1\ndef build(p): pass\n",
    "large.py": b"# " + b"x" * 2_000_000,
}

DESIGNS: dict[str, bytes] = {
    "deep.json": b'{"files":' + b"[" * 200_000 + b"]" * 200_000 + b"}",
    "list.json": b"[]",
    "words.json": b'{"payload": "a", "files": ["b"]}',
    "numbers.json": b'{"payload": 3, "files": []}',
    "paths.json": b'{"payload": "a", "files": [{"path": 3}]}',
    "device.json": b'{"payload": "a", "files": [{"path": "/dev/zero.stl"}]}',
}
