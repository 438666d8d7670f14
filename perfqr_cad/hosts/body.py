"""A solid as tagged triangles, for questions that rays answer fast: what is hit, how thick, facing where."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from perfqr_cad.errors import KernelError
from perfqr_cad.geometry import Triangles
from perfqr_cad.geometry.arrays import Array, Indices, Mask
from perfqr_cad.geometry.graph import components

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Face, TopoDS_Solid


CHORD_MM = 0.02  # greatest distance between mesh and solid: a tenth of a printed layer
CHORD_SHARE = 1e-5  # of the diagonal: on a very large solid the mesh is coarser
TURN_RAD = 0.15  # greatest turn between neighbouring facets
# Nodes on a shared edge agree to the kernel's tolerance (1e-7 mm); on sloppy imports to about this.
WELD_MM = 1e-5
LEAST_FACING = 0.1  # length of the mean normal of a face that faces one side more than the others


@dataclass(frozen=True)
class Crossings:
    """Where rays cross the surface, sorted by ray and then by distance; all (k,) but `normal` (k, 3)."""

    ray: Indices
    distance_mm: Array
    triangle: Indices
    normal: Array
    entering: Mask


@dataclass(frozen=True)
class Body:
    """A closed mesh, the number of the face each triangle lies on, and unit normals at triangle corners.

    face_of         (m,) counts from 0; on a plain mesh 0 is outer surface and 1 the walls of cavities
    corner_normals  (m, 3, 3)
    faceted         whether it is a plain mesh
    """

    triangles: Triangles
    face_of: Indices
    corner_normals: Array
    faceted: bool = False

    @cached_property
    def diagonal_mm(self) -> float:
        """Diagonal of the bounding box."""
        return float(np.linalg.norm(np.ptp(self.triangles.vertices, axis=0)))

    @cached_property
    def centre_mm(self) -> Array:
        """Centre of the bounding box."""
        return (self.triangles.vertices.min(axis=0) + self.triangles.vertices.max(axis=0)) / 2

    @cached_property
    def facet_normals(self) -> Array:
        """Unit normals of the flat triangles, (m, 3)."""
        a, b, c = np.moveaxis(self.triangles.vertices[self.triangles.faces], 1, 0)
        normal = np.cross(b - a, c - a)
        return normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]

    @cached_property
    def areas_mm2(self) -> Array:
        """Areas of the triangles, (m,)."""
        a, b, c = np.moveaxis(self.triangles.vertices[self.triangles.faces], 1, 0)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2

    @cached_property
    def _rays(self) -> Any:
        import trimesh
        from trimesh.ray.ray_pyembree import RayMeshIntersector

        mesh = trimesh.Trimesh(self.triangles.vertices, self.triangles.faces, process=False, validate=False)
        return RayMeshIntersector(mesh)

    def crossings(self, origins: Array, directions: Array) -> Crossings:
        """All crossings of rays (k, 3) with the surface, ahead of their origins; directions are unit
        vectors."""
        triangle, ray, at = self._rays.intersects_id(
            origins, directions, multiple_hits=True, return_locations=True
        )
        distance = np.einsum("ki,ki->k", at - origins[ray], directions[ray])
        order = np.lexsort((distance, ray))
        triangle, ray, at, distance = triangle[order], ray[order], at[order], distance[order]
        entering = np.einsum("ki,ki->k", self.facet_normals[triangle], directions[ray]) < 0
        return Crossings(ray, distance, triangle, self._normals_at(triangle, at), entering)

    def first_entered(self, point: Array, look: Array) -> tuple[int, Array] | None:
        """The triangle through which a look from a point (3,) along a unit direction (3,) first enters the
        material, and where; None where it misses."""
        found = self.crossings(point[None], look[None])
        entering = np.flatnonzero(found.entering)
        if not len(entering):
            return None
        first = entering[0]
        return int(found.triangle[first]), point + found.distance_mm[first] * look

    def nearest(self, point: Array) -> tuple[int, Array]:
        """The triangle nearest to a point and the point of it that is nearest."""
        import trimesh

        corners = self.triangles.vertices[self.triangles.faces]
        on = trimesh.triangles.closest_point(corners, np.broadcast_to(point, (len(corners), 3)))
        triangle = int(np.argmin(np.linalg.norm(on - point, axis=1)))
        return triangle, on[triangle]

    def samples(self, count: int, seed: int, faces: Indices | None = None) -> tuple[Array, Array, Indices]:
        """Points (count, 3) spread evenly over the surface (or some faces), normals, and numbers of their
        faces."""
        weight = self.areas_mm2 if faces is None else self.areas_mm2 * np.isin(self.face_of, faces)
        random = np.random.default_rng(seed)
        triangle = random.choice(len(weight), count, p=weight / weight.sum())
        u, v = random.random((2, count))
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        a, b, c = np.moveaxis(self.triangles.vertices[self.triangles.faces[triangle]], 1, 0)
        points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
        return points, self._normals_at(triangle, points), self.face_of[triangle]

    def middle_of(self, face: int) -> Array | None:
        """The centroid (3,) of a face's surface; None where that looks to all sides, as round a pipe."""
        own = self.face_of == face
        weight = self.areas_mm2[own] / self.areas_mm2[own].sum()
        if np.linalg.norm(weight @ self.facet_normals[own]) < LEAST_FACING:
            return None
        return weight @ self.triangles.vertices[self.triangles.faces[own]].mean(axis=1)

    def _normals_at(self, triangle: Indices, at: Array) -> Array:
        """Corner normals interpolated at points of triangles."""
        a, b, c = np.moveaxis(self.triangles.vertices[self.triangles.faces[triangle]], 1, 0)
        flat = self.facet_normals[triangle]
        double_area = np.maximum(np.einsum("ki,ki->k", np.cross(b - a, c - a), flat), 1e-300)
        wb = np.einsum("ki,ki->k", np.cross(at - a, c - a), flat) / double_area
        wc = np.einsum("ki,ki->k", np.cross(b - a, at - a), flat) / double_area
        weights = np.stack([1 - wb - wc, wb, wc], axis=1)
        normal = np.einsum("kj,kji->ki", weights, self.corner_normals[triangle])
        return normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]


def body_of_mesh(triangles: Triangles) -> Body:
    """A closed mesh with its facets' own normals; connected surfaces of negative volume bound cavities."""
    surface = triangles.vertex_components[triangles.faces[:, 0]]
    corners = triangles.vertices[triangles.faces] - triangles.vertices.mean(axis=0)
    volumes = np.bincount(
        surface, np.einsum("ki,ki->k", np.cross(corners[:, 0], corners[:, 1]), corners[:, 2])
    )
    inner = (volumes[surface] < 0).astype(np.int64)
    bare = Body(triangles, inner, np.zeros((0, 3, 3)), True)
    return Body(triangles, inner, np.repeat(bare.facet_normals[:, None, :], 3, axis=1), True)


def body_of_solid(solid: TopoDS_Solid, faces: list[TopoDS_Face]) -> Body:
    """The solid's mesh with face numbers (places in `faces`) and exact normals.

    Raises `KernelError` when a face cannot be meshed.
    """
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    box = Bnd_Box()
    BRepBndLib.Add_s(solid, box, False)
    chord = max(CHORD_MM, CHORD_SHARE * float(np.sqrt(box.SquareExtent())))
    BRepMesh_IncrementalMesh(solid, chord, False, TURN_RAD, True)
    pieces = [_facets(face) for face in faces]
    missing = [i + 1 for i, piece in enumerate(pieces) if piece is None]
    if missing:
        raise KernelError(f"face {missing[0]} of the solid cannot be meshed: repair it in the CAD system")
    points, triangles, normals, tags = [], [], [], []
    offset = 0
    for tag, piece in enumerate(p for p in pieces if p is not None):
        nodes, corners, node_normals = piece
        points.append(nodes)
        triangles.append(corners + offset)
        normals.append(node_normals[corners])
        tags.append(np.full(len(corners), tag))
        offset += len(nodes)
    mesh, kept = weld(np.vstack(points), np.vstack(triangles), WELD_MM)
    return Body(mesh, np.concatenate(tags)[kept], np.concatenate(normals)[kept])


def weld(vertices: Array, faces: Indices, tolerance_mm: float) -> tuple[Triangles, Mask]:
    """Vertices closer than the tolerance made one; triangles that lose a corner are dropped (mask
    returned)."""
    from scipy.spatial import cKDTree

    near = cKDTree(vertices).query_pairs(tolerance_mm, output_type="ndarray")
    label = components(near, len(vertices))
    _, first, index = np.unique(label, return_index=True, return_inverse=True)
    corners = index[faces]
    kept = (
        (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    )
    return Triangles(vertices[first], corners[kept]), kept


def _facets(face: TopoDS_Face) -> tuple[Array, Indices, Array] | None:
    """Nodes, outward triangles and outward node normals of one face."""
    from OCP.BRep import BRep_Tool
    from OCP.StdPrs import StdPrs_ToolTriangulatedShape
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location

    location = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face, location)
    if mesh is None:
        return None
    StdPrs_ToolTriangulatedShape.ComputeNormals_s(face, mesh)
    count = range(1, mesh.NbNodes() + 1)
    nodes = np.array([mesh.Node(i).Coord() for i in count])
    normals = np.array([mesh.Normal(i).Coord() for i in count])
    triangles = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)], np.int64) - 1
    if not location.IsIdentity():
        matrix = location.Transformation()
        rotation = np.array([[matrix.Value(r, c) for c in (1, 2, 3)] for r in (1, 2, 3)])
        nodes = nodes @ rotation.T + [matrix.Value(r, 4) for r in (1, 2, 3)]
        normals = normals @ rotation.T
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        triangles, normals = triangles[:, ::-1], -normals
    # The kernel may or may not have turned the normals with the face: the triangles decide.
    a, b, c = np.moveaxis(nodes[triangles], 1, 0)
    agreement = np.einsum("ki,ki->", np.cross(b - a, c - a), normals[triangles[:, 0]])
    return nodes, triangles, normals if agreement > 0 else -normals
