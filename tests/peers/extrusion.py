"""Footprints of a map, united and extruded to a mesh and a Mitsuba scene."""

import json
from pathlib import Path

import numpy as np
import shapely
from shapely.geometry.polygon import orient


def united(map_file):
    """United footprints of a RadioMapSeer file [m], outer rings counter-clockwise, holes clockwise, no vertex in a straight wall."""
    rings = json.loads(Path(map_file).read_text())
    union = shapely.union_all([shapely.make_valid(shapely.Polygon(ring)) for ring in rings])
    parts = [part for part in shapely.get_parts(union) if part.geom_type == "Polygon"]
    return [orient(shapely.Polygon(corners(part.exterior), [corners(hole) for hole in part.interiors])) for part in parts]


def corners(ring):
    """Vertices of a closed ring at which it bends."""
    points = np.array(ring.coords)[:-1]
    before, after = points - np.roll(points, 1, 0), np.roll(points, -1, 0) - points
    return points[np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]) > 1e-9]


def mesh(polygons, height_m, capped):
    """Vertices (N, 3) [m] and triangles (M, 3) of walls from z = 0 to the height, normals outwards; with roof and floor if capped."""
    vertices, triangles = [], []
    for polygon in polygons:
        number = {}
        for ring in [polygon.exterior, *polygon.interiors]:
            points = ring.coords[:-1]
            first = len(vertices)
            for k, (x, y) in enumerate(points):
                # A corner that two rings share stays two vertices: an edge belongs to two walls.
                number.setdefault((x, y), first + 2 * k)
                vertices += [(x, y, 0.0), (x, y, height_m)]
            for k in range(len(points)):
                a, b = first + 2 * k, first + 2 * ((k + 1) % len(points))
                triangles += [(a, b, b + 1), (a, b + 1, a + 1)]
        if capped:
            for cap in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon)):
                a, b, c = (number[point] for point in orient(cap).exterior.coords[:-1])
                triangles += [(a + 1, b + 1, c + 1), (a, c, b)]
    return np.array(vertices), np.array(triangles)


def check_closed(triangles):
    """Refuse a mesh in which an edge is not shared by exactly two triangles that run along it in opposite directions."""
    edges = {(int(t[k]), int(t[(k + 1) % 3])) for t in triangles for k in range(3)}
    if len(edges) != 3 * len(triangles) or any((b, a) not in edges for a, b in edges):
        raise ValueError("the mesh is not closed: unite the footprints without rings that touch themselves")


def write_scene(folder, polygons, height_m, capped, material, thickness_m):
    """Write buildings.ply and scene.xml of one building mesh of an ITU material into the folder; return the scene's path."""
    vertices, triangles = mesh(polygons, height_m, capped)
    if capped:
        check_closed(triangles)
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()] + [f"3 {a} {b} {c}" for a, b, c in triangles]
    folder = Path(folder)
    (folder / "buildings.ply").write_text("\n".join(lines) + "\n")
    # Smooth normals would bend the walls, hence face_normals.
    (folder / "scene.xml").write_text(f"""<scene version="2.1.0">
  <bsdf type="itu-radio-material" id="walls">
    <string name="type" value="{material}"/>
    <float name="thickness" value="{thickness_m}"/>
  </bsdf>
  <shape type="ply" id="buildings">
    <string name="filename" value="buildings.ply"/>
    <boolean name="face_normals" value="true"/>
    <ref name="bsdf" id="walls"/>
  </shape>
</scene>
""")
    return folder / "scene.xml"
