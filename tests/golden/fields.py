"""Golden values for the fields of aps-raytrace on a small city, by exhaustion.

    python3 fields.py

writes fields.json beside this file. Every pixel's centre is tried against the transmitter, every corner and every sequence of
walls, every line against every wall; there are no beams, no index and no exact signs. Instead the script stops unless each
decision is far from falling the other way. Made with NumPy 2.
"""

import itertools
import json
from pathlib import Path

import numpy as np

# Counter-clockwise; a house, an angle, a turned house, a block with a gateway to its yard.
CITY = [
    [(6, 5), (15, 5), (15, 12), (6, 12)],
    [(22, 4), (35, 4), (35, 9), (27, 9), (27, 16), (22, 16)],
    [(8.2, 20.1), (14.1, 18.3), (16.9, 27.4), (11.2, 29.1)],
    [(21, 21), (36, 21), (36, 36), (30, 36), (30, 32), (32, 32), (32, 25), (25, 25), (25, 32), (27, 32), (27, 36), (21, 36)],
]
SIDE, PIXEL = 40, 1.0
TX = (18.31, 15.77)
RECEIVERS = [(3.29, 33.46), (28.63, 28.17), (38.21, 12.64)]
DIRECTIONS, RANGES, BOUNCES = 24, np.geomspace(1.0, 60.0, 10), 3
NEAR_CORNER = 2.0
CLEAR = 1e-6

A = np.array([p for ring in CITY for p in ring], float)
B = np.array([p for ring in CITY for p in ring[1:] + ring[:1]], float)
BEFORE = np.array([p for ring in CITY for p in ring[-1:] + ring[:-1]], float)
D = B - A
LENGTH = np.hypot(*D.T)
OUT = np.c_[D[:, 1], -D[:, 0]] / LENGTH[:, None]


def cross(u, v):
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


closest = [np.inf]


def note(margin, mask=True):
    """Remembers the smallest margin of a decision."""
    margin = np.where(mask, np.abs(margin), np.inf)
    closest[0] = min(closest[0], margin.min(initial=np.inf))


def is_free(p, q, skip=(), is_close_call=True):
    """Tells which segments p[i] to q[i] meet no wall; walls in `skip` are left out.

    Lengths around corners do not jump: there, close decisions do not count.
    """
    free = np.ones(len(q), bool)
    p = np.broadcast_to(p, q.shape)
    for w in range(len(A)):
        if w in skip:
            continue
        a, b = A[w], B[w]
        side_p, side_q = (cross(D[w] / LENGTH[w], x - a) for x in (p, q))
        ray = (q - p) / np.maximum(np.hypot(*(q - p).T), 1e-12)[:, None]
        side_a, side_b = (cross(ray, x - p) for x in (a, b))
        apart = (side_p * side_q < 0) & (side_a * side_b <= 0)
        if is_close_call:
            note(np.minimum(np.abs(side_a), np.abs(side_b)), (side_p * side_q < 0) & free)
        free &= ~apart
    return free


def is_inside(p):
    """Tells which points are in a building: an odd number of walls to the right."""
    y = p[:, None, 1]
    crosses = (A[:, 1] <= y) != (B[:, 1] <= y)
    x = A[:, 0] + (y - A[:, 1]) * D[:, 0] / np.where(D[:, 1] == 0, np.inf, D[:, 1])
    note(x - p[:, None, 0], crosses)
    return ((x > p[:, None, 0]) & crosses).sum(1) % 2 == 1


xs = np.arange(SIDE) + 0.5
CENTRES = np.stack(np.meshgrid(xs, xs), -1).reshape(-1, 2)
INSIDE = is_inside(CENTRES)
tx = np.array(TX)

# Corners, moved off their building by little enough to count as there.
convex = cross(A - BEFORE, D) > 0
bisector = (A - BEFORE) / np.hypot(*(A - BEFORE).T)[:, None] - D / LENGTH[:, None]
CORNERS = (A + 1e-6 * bisector / np.hypot(*bisector.T)[:, None])[convex]
corners_exact = A[convex]


def distance(p, q):
    return np.hypot(*np.moveaxis(np.asarray(p) - np.asarray(q), -1, 0))


# Ways to the corners: relax all pairs until nothing is shorter.
pairs = np.array([is_free(c, CORNERS, (), False) for c in CORNERS])
steps = np.where(pairs & pairs.T, distance(corners_exact[:, None], corners_exact[None]), np.inf)
to_corner = np.where(is_free(tx, CORNERS, (), False), distance(tx, corners_exact), np.inf)
while True:
    shorter = np.minimum(to_corner, (to_corner[:, None] + steps).min(0))
    if (shorter == to_corner).all():
        break
    to_corner = shorter


def geodesic(places):
    """Length over each source to places: the transmitter, then the corners."""
    rows = [np.where(is_free(tx, places), distance(places, tx), np.inf)]
    for c, exact, length in zip(CORNERS, corners_exact, to_corner):
        rows.append(np.where(is_free(c, places, (), False), length + distance(places, exact), np.inf))
    return np.array(rows)


def mirror(p, w):
    return p - 2 * ((p - A[w]) @ OUT[w])[..., None] * OUT[w] if p.ndim > 1 else p - 2 * ((p - A[w]) @ OUT[w]) * OUT[w]


def reflected(sequence, places):
    """Image over a sequence of walls, and the lengths to places, infinite where there is no such path."""
    images = [tx]
    for w in sequence:
        if (images[-1] - A[w]) @ OUT[w] <= 0:
            return None
        images.append(mirror(images[-1], w))
    length = distance(places, images[-1])
    ok = np.ones(len(places), bool)
    target, skip = places, None
    for image, w in zip(images[:0:-1], sequence[::-1]):
        front = (target - A[w]) @ OUT[w]
        behind = (image - A[w]) @ OUT[w]
        part = front / np.where(front - behind == 0, np.inf, front - behind)
        point = target + part[:, None] * (image - target)
        along = (point - A[w]) @ D[w] / LENGTH[w]
        within = (along >= 0) & (along <= LENGTH[w])
        note(np.minimum(np.abs(along), np.abs(along - LENGTH[w])), ok & (front > 0))
        ok &= (front > 0) & within
        if not ok.any():
            return None
        skip_here = (w,) if skip is None else (w, skip)
        ok[ok] &= is_free(point[ok], target[ok], skip_here)
        target, skip = point, w
    ok[ok] &= is_free(tx, target[ok], (skip,))
    return images[-1], np.where(ok, length, np.inf)


def lit(order):
    """Images and lengths of one order at all centres."""
    found = []
    for sequence in itertools.product(range(len(A)), repeat=order):
        if all(a != b for a, b in zip(sequence, sequence[1:])):
            result = reflected(sequence, CENTRES)
            if result is not None and np.isfinite(result[1]).any():
                found.append(result)
    return found


def rule(lengths, places, offsets):
    """For each pixel the source that rules it, -1 for none; pixels indoors beside the street take over a neighbour's."""
    lengths = np.where(INSIDE, np.inf, lengths)
    source = np.where(np.isfinite(lengths.min(0)), lengths.argmin(0), -1)
    with_rim = source.copy()
    for pixel in np.flatnonzero(INSIDE):
        x, y = pixel % SIDE, pixel // SIDE
        best = np.inf
        for dx, dy in itertools.product((-1, 0, 1), repeat=2):
            if not (0 <= x + dx < SIDE and 0 <= y + dy < SIDE):
                continue
            other = (y + dy) * SIDE + x + dx
            if INSIDE[other] or source[other] < 0:
                continue
            length = offsets[source[other]] + distance(CENTRES[pixel], places[source[other]])
            if length < best:
                best, with_rim[pixel] = length, source[other]
    return with_rim


fields = []
geo = geodesic(CENTRES)
places, offsets = np.vstack([tx, corners_exact]), np.r_[0.0, to_corner]
fields.append((rule(geo, places, offsets), places, offsets))
for order in (1, 2):
    found = lit(order)
    places = np.array([image for image, _ in found])
    fields.append((rule(np.array([length for _, length in found]), places, np.zeros(len(found))), places, np.zeros(len(found))))


def at(field, pixels, positions):
    """Lengths of a field's ways to positions in pixels; pixel -1 is none."""
    source, places, offsets = field
    s = np.where(pixels >= 0, source[pixels], -1)
    return np.where(s >= 0, offsets[s] + distance(positions, places[s]), np.inf)


def follow(rx):
    """Positions of the rays (range, direction), and bounces before each; -1 where the ray has ended."""
    positions, bounces = np.zeros((len(RANGES), DIRECTIONS, 2)), np.full((len(RANGES), DIRECTIONS), -1)
    for i in range(DIRECTIONS):
        angle = (i + 0.5) * 2 * np.pi / DIRECTIONS
        p, u, start, last = rx, np.array([np.cos(angle), np.sin(angle)]), 0.0, None
        for bounce in range(BOUNCES + 1):
            towards = -(OUT @ u)
            t = ((p - A) * OUT).sum(1) / np.where(towards > 0, towards, np.inf)
            along = ((p + t[:, None] * u - A) * D).sum(1) / LENGTH
            hit = (towards > 0) & (t > -1e-9) & (along >= 0) & (along <= LENGTH)
            note(np.minimum(along, LENGTH - along), (towards > 0) & (t > -1e-9))
            if last is not None:
                hit[last] = False
            t = np.where(hit, t, np.inf)
            last = t.argmin()
            here = (RANGES >= start) & (RANGES < start + t[last])
            note(RANGES - (start + t[last]))
            positions[here, i] = p + (RANGES[here] - start)[:, None] * u
            bounces[here, i] = bounce
            if not np.isfinite(t[last]):
                break
            start, p = start + t[last], p + t[last] * u
            u = u - 2 * (u @ OUT[last]) * OUT[last]
    return positions, bounces


near_corner = (distance(CENTRES[:, None], corners_exact[None]) < NEAR_CORNER * PIXEL).any(1)


def link(rx):
    rx = np.array(rx)
    positions, bounces = follow(rx)
    cell = np.floor(positions / PIXEL).astype(int)
    note((positions / PIXEL - np.round(positions / PIXEL)), (bounces >= 0)[..., None])
    inside = (bounces >= 0) & (cell >= 0).all(-1) & (cell < SIDE).all(-1)
    pixels = np.where(inside, cell[..., 1] * SIDE + cell[..., 0], -1)
    r, d = RANGES[:, None], distance(rx, tx)
    to_rx = geodesic(rx[None])[:, 0].min()
    g, once, twice = (at(field, pixels, positions) for field in fields)
    detour = np.maximum(g + r - to_rx, 0)
    decay = lambda x, scale: np.where(np.isfinite(x), np.exp(-np.where(np.isfinite(x), x, 0) / scale), 0.0)
    excess = [np.where(np.isfinite(l), np.maximum(l + r - d, 0), np.inf) for l in (once, twice)]
    in_sight = (pixels >= 0) & (fields[0][0][pixels] == 0)
    planes = [bounces == 0, bounces == 1, bounces == 2, in_sight, decay(detour, 2), decay(detour, 20)]
    for length, more in zip((once, twice), excess):
        planes += [np.isfinite(length), decay(more, 100)]
    planes += [(pixels >= 0) & near_corner[pixels], np.broadcast_to(np.log(r) / 3 - 1, bounces.shape)]
    angles = (np.arange(DIRECTIONS) + 0.5) * 2 * np.pi / DIRECTIONS - np.arctan2(*(tx - rx)[::-1])
    log = lambda x: np.full(DIRECTIONS, np.log(np.clip(x, 1, 1200)) / 3 - 1)
    numbers = [np.cos(angles), np.sin(angles), log(d), log(to_rx)]
    return {"rx": rx.tolist(), "planes": rounded(np.array(planes, float)), "numbers": rounded(np.array(numbers))}


def rounded(values):
    return [None if not np.isfinite(v) else round(float(v), 6) for v in np.ravel(values)]


links = [link(rx) for rx in RECEIVERS]
pixels = np.arange(SIDE * SIDE)
out = {
    "city": CITY,
    "side": SIDE,
    "tx": TX,
    "directions": DIRECTIONS,
    "ranges_m": [float(r) for r in RANGES],
    "in_sight": (fields[0][0] == 0).astype(int).tolist(),
    "geodesic_m": rounded(at(fields[0], pixels, CENTRES)),
    "once_m": rounded(at(fields[1], pixels, CENTRES)),
    "twice_m": rounded(at(fields[2], pixels, CENTRES)),
    "links": links,
}
assert closest[0] > CLEAR, f"a decision is {closest[0]} m from falling the other way: move a terminal"
path = Path(__file__).with_name("fields.json")
path.write_text(json.dumps(out, separators=(",", ":")) + "\n")
print("closest decision", closest[0], "m;", path.stat().st_size, "bytes; lit", [(f[0] >= 0).sum() for f in fields])
