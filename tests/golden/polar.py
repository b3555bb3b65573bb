"""Golden values for the polar view of aps-raytrace on a small city, by exhaustion.

    python3 polar.py

writes polar.json beside this file. Every sequence of walls is tried against every corner, every line against every wall; shortest
ways come from relaxing all pairs of corners. There are no views, no index and no exact signs. Instead the script stops unless each
decision is far from falling the other way. Made with NumPy 2.
"""

import itertools
import json
from pathlib import Path

import numpy as np


def turned(x, y, angle_deg, points):
    """Corners of a building, counter-clockwise, moved and turned: no two walls of the city are parallel by chance."""
    a = np.radians(angle_deg)
    return [(round(x + np.cos(a) * u - np.sin(a) * v, 2), round(y + np.sin(a) * u + np.cos(a) * v, 2)) for u, v in points]


def house(width, depth):
    return [(0, 0), (width, 0), (width, depth), (0, depth)]


CITY = [
    turned(12.3, 9.7, 4, house(21, 12)),
    turned(47.1, 8.2, -5, [(0, 0), (26, 0), (26, 9), (10, 9), (10, 20), (0, 20)]),
    turned(86.4, 11.9, 13, house(11, 17)),
    turned(17.6, 34.8, 9, house(14, 19)),
    # A block with a gateway to its yard.
    turned(45.3, 41.2, -3, [(0, 0), (30, 0), (30, 30), (19, 30), (19, 24), (24, 24), (24, 6), (6, 6), (6, 24), (11, 24), (11, 30), (0, 30)]),
    turned(88.7, 42.6, 6, house(13, 22)),
    turned(8.9, 66.3, -8, [(0, 0), (17, 0), (9, 23)]),
    turned(38.2, 82.6, 11, house(24, 11)),
    turned(77.5, 80.4, 2, house(23, 8)),
]
TRANSMITTERS = [(38.71, 27.33), (80.17, 35.41)]
RECEIVERS = [(5.23, 49.17), (62.39, 57.83), (71.87, 91.06), (79.94, 6.27)]
LINKS = [(0, 0), (0, 2), (1, 1), (1, 3), (0, 3), (1, 2)]
DIRECTIONS, BOUNCES = 720, 2
ROWS = range(0, DIRECTIONS, 2)
CLEAR_M = 1e-6
CLEAR_RANK = 1e-3

A = np.array([p for ring in CITY for p in ring])
B = np.array([p for ring in CITY for p in ring[1:] + ring[:1]])
PREVIOUS = np.concatenate([np.roll(np.arange(len(ring)), 1) + sum(map(len, CITY[:i])) for i, ring in enumerate(CITY)])
D = B - A
LENGTH = np.hypot(*D.T)
ALONG = D / LENGTH[:, None]
OUT = np.c_[ALONG[:, 1], -ALONG[:, 0]]
WALLS = np.arange(len(A))

closest_m, closest_rank = [np.inf], [np.inf]


def note(margin):
    """Remembers the smallest margin of a decision."""
    closest_m[0] = min(closest_m[0], np.abs(margin).min(initial=np.inf))


def cross(u, v):
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def size(v):
    return np.hypot(v[..., 0], v[..., 1])


CONVEX = np.flatnonzero(cross(D[PREVIOUS], D) > 0)
CORNERS = A[CONVEX]
# The walls that meet at each corner, the one that starts there first.
FACES = np.c_[CONVEX, PREVIOUS[CONVEX]]
BISECTOR = ALONG[FACES[:, 0]] - ALONG[FACES[:, 1]]
BISECTOR /= size(BISECTOR)[:, None]


def depth(p, corners):
    """Distance of places inside the angle between the walls of corners; negative outside of it."""
    heights = ((p[:, None] - CORNERS[corners][:, None]) * OUT[FACES[corners]]).sum(-1)
    return -heights.max(-1)


def overlap(p, q, skip):
    """Length by which the segments p[i] to q[i] cross walls, but those in `skip`: negative if they pass them."""
    ray, r = (q - p)[:, None], A - p[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        t, s = cross(r, D) / cross(ray, D), cross(r, ray) / cross(ray, D)
        each = np.minimum(np.minimum(t, 1 - t) * size(ray), np.minimum(s, 1 - s) * LENGTH)
    each = np.where(skip | ~np.isfinite(each), -np.inf, each)
    return each.max(1)


def skipping(count, *walls):
    """Mask (segment, wall) of walls to skip: each an index, or one a segment."""
    return np.any([np.broadcast_to(w, count)[:, None] == WALLS for w in walls], 0)


def sees(p, corners, walls=(), is_noted=True):
    """Tells which of the corners see the places p; the segments begin on `walls`."""
    p = np.broadcast_to(p, (len(corners), 2))
    skip = skipping(len(corners), *FACES[corners].T, *walls)
    across = np.maximum(overlap(p, CORNERS[corners], skip), depth(p, corners))
    if is_noted:
        note(across)
    return across < (0 if is_noted else 1e-9)


ALL = np.arange(len(CORNERS))


def touches(p, corners, walls=()):
    """Sight of corners from other corners: along a wall nothing is decided."""
    return sees(p, corners, walls, False)


def goes_on(p, corner):
    """Tells if a string from p that bends at a corner can: straight on behind it is street."""
    ahead = (CORNERS[corner] - p) / size(CORNERS[corner] - p)
    return depth((CORNERS[corner] + ahead)[None], np.array([corner]))[0] < 1e-9


# Pairs of corners in sight of each other, and those of them that a tight string may have.
IN_SIGHT = np.array([touches(CORNERS[c], ALL, FACES[c]) & (depth(CORNERS, np.full(len(ALL), c)) < 1e-9) & (ALL != c) for c in ALL])
STEP = size(CORNERS[:, None] - CORNERS)
TIGHT = np.array([[IN_SIGHT[p, q] and goes_on(CORNERS[p], q) and goes_on(CORNERS[q], p) for q in ALL] for p in ALL])


def mirrored(p, w):
    return p - 2 * ((p - A[w]) @ OUT[w]) * OUT[w]


def reflected(tx, walls):
    """Image of tx over a sequence of walls, and the corners that it lights."""
    images = [tx]
    for w in walls:
        if (images[-1] - A[w]) @ OUT[w] <= 0:
            return None, []
        images.append(mirrored(images[-1], w))
    # A corner is not behind its own walls.
    corners = ALL[~(FACES == walls[-1]).any(1)]
    target, before = CORNERS[corners], None
    for image, w in zip(images[:0:-1], walls[::-1]):
        front, behind = (target - A[w]) @ OUT[w], (image - A[w]) @ OUT[w]
        point = target + (front / np.where(front == behind, np.inf, front - behind))[:, None] * (image - target)
        place = (point - A[w]) @ ALONG[w]
        within = np.minimum(np.minimum(place, LENGTH[w] - place), front)
        note(within)
        keep = within > 0
        corners, target, point = corners[keep], target[keep], point[keep]
        if not len(corners):
            return None, []
        if before is None:
            free = sees(point, corners, [w])
        else:
            leg = overlap(point, target, skipping(len(corners), w, before))
            note(leg)
            free = leg < 0
        corners, target, before = corners[free], point[free], w
    leg = overlap(np.broadcast_to(tx, target.shape), target, skipping(len(corners), before))
    note(leg)
    return images[-1], corners[leg < 0]


def unfolded_cosines(walls, ray):
    """Cosines of incidence of a ray that arrives last from the last wall."""
    out = []
    for w in walls[::-1]:
        out.append(abs(ray @ OUT[w]))
        ray = ray - 2 * (ray @ OUT[w]) * OUT[w]
    return sum(out)


def strings(tx):
    """Length to each corner of the shortest tight string that bends there, and the corners before."""
    first = sees(tx, ALL) & [goes_on(tx, c) for c in ALL]
    length = np.where(first, size(CORNERS - tx), np.inf)
    via = np.where(first, -1, -2)
    step = np.where(TIGHT, STEP, np.inf)
    while True:
        over = length[:, None] + step
        shorter = over.min(0) < length - 1e-9
        if not shorter.any():
            break
        via = np.where(shorter, over.argmin(0), via)
        length = np.where(shorter, over.min(0), length)
    ties = np.sort(np.vstack([np.where(first, size(CORNERS - tx), np.inf), over]), 0)
    note((ties[1] - ties[0])[np.isfinite(ties[1])])
    return length, via


def turn(u, v):
    return abs(np.arctan2(cross(u, v), u @ v))


class Transmitter:
    """Ways to each corner by kind: length, unit vector of arrival, sum of cosines, turn before, number of corners."""

    def __init__(self, tx):
        self.at = tx = np.array(tx)
        self.ways = [[[] for _ in ALL] for _ in range(4)]
        self.in_sight = sees(tx, ALL)
        for c in ALL[self.in_sight]:
            self.add(0, c, tx, 0.0)
        for order in (1, 2):
            for walls in itertools.product(WALLS, repeat=order):
                if order == 1 or walls[0] != walls[1]:
                    image, corners = reflected(tx, walls)
                    for c in corners:
                        ray = CORNERS[c] - image
                        self.add(order, c, image, unfolded_cosines(walls, ray / size(ray)))
        length, via = strings(tx)
        for c in ALL[np.isfinite(length)]:
            chain = [c]
            while via[chain[-1]] >= 0:
                chain.append(via[chain[-1]])
            points = np.array([tx] + [CORNERS[k] for k in chain[::-1]])
            legs = np.diff(points, axis=0)
            if len(chain) > 1:
                turns = sum(turn(u, v) for u, v in zip(legs, legs[1:]))
                self.ways[3][c].append((length[c], legs[-1] / size(legs[-1]), 0.0, turns, len(chain)))
        # The shortest way to each corner, bent there or not.
        self.to_corner = np.where(self.in_sight, size(CORNERS - tx), np.inf)
        step = np.where(IN_SIGHT, STEP, np.inf)
        for _ in ALL:
            self.to_corner = np.minimum(self.to_corner, (self.to_corner[:, None] + step).min(0))

    def add(self, kind, c, source, cosines):
        ray = CORNERS[c] - source
        self.ways[kind][c].append((size(ray), ray / size(ray), cosines, 0.0, 1))


def segments(rx, angle):
    """Start, unit vector, unfolded distance, length, wall at the end, sum of cosines before and the last of them of each piece of a ray."""
    p, u, start, cosines, last = rx, np.array([np.cos(angle), np.sin(angle)]), 0.0, [0.0], None
    for _ in range(BOUNCES + 1):
        t = ((A - p) * OUT).sum(1) / (OUT @ u)
        place = ((p + t[:, None] * u - A) * ALONG).sum(1)
        inside = np.minimum(place, LENGTH - place)
        front = (OUT @ u < 0) & (t > 1e-9) & (WALLS != last)
        hit = np.where(front & (inside > 0), t, np.inf)
        last = hit.argmin()
        note(inside[front & (t <= hit[last])])
        yield p, u, start, hit[last], last, sum(cosines), cosines[-1]
        if not np.isfinite(hit[last]):
            return
        p, start = p + hit[last] * u, start + hit[last]
        cosines.append(-(u @ OUT[last]))
        u = u - 2 * (u @ OUT[last]) * OUT[last]


def passed(segment, place):
    """Distance to a place beside a segment, and the tangent of the angle to it; whatever stands between."""
    p, u, start, length, *_ = segment
    along, across = (place - p) @ u, cross(u, place - p)
    foot = start + along
    margin = min(along, length - along, BEAM * foot - abs(across))
    note(margin)
    return (p + along * u, np.hypot(foot, across), across / foot) if margin > 0 else None


def stops_before(segment, corner):
    """The same for a corner at the end of the wall that the segment ends at, if it ends before it is abreast of the corner."""
    p, u, start, length, wall, *_ = segment
    if not np.isfinite(length) or wall not in FACES[corner]:
        return None
    along, across = (CORNERS[corner] - p) @ u, cross(u, CORNERS[corner] - p)
    foot = start + along
    margin = min(along - length, BEAM * foot - abs(across))
    note(margin)
    if margin <= 0:
        return None
    leg = overlap((p + length * u)[None], CORNERS[corner][None], skipping(1, *FACES[corner]))
    note(leg)
    return (np.hypot(foot, across), across / foot) if leg[0] < 0 else None


BEAM = 2 * np.pi / DIRECTIONS


def features(tx, rx, segment, bounces):
    """The ways along a segment: for each kind that has one, the features of the way that ranks first."""
    p, u, start, length, wall, cos_sum, cos_last = segment
    d = max(size(tx.at - rx), 1.0)

    def common(range_m, tangent):
        beam = tangent / BEAM
        excess = np.clip(np.log(range_m / d), -0.1, 3)
        return {0: 1 - abs(beam), 1: 1, 2: 0.5 * beam * (-1) ** bounces, 3: excess, 8: cos_sum, 9: cos_last, 11: 0.3 * np.log(range_m) - 1}

    found = {}
    near = passed(segment, tx.at)
    if near:
        foot, range_m, tangent = near
        leg = overlap(foot[None], tx.at[None], skipping(1, -1))
        note(leg)
        if leg[0] < 0:
            found[0] = common(range_m, tangent)
    near = [(c, passed(segment, CORNERS[c])) for c in ALL]
    near = [(c, *n[1:]) for c, n in near if n and sees(n[0], np.array([c]))[0]]
    near += [(c, *n) for c in ALL if (n := stops_before(segment, c))]
    for kind in range(4):
        ways = []
        for c, s1, tangent in near:
            ahead = u + tangent * np.array([-u[1], u[0]])
            ahead /= size(ahead)
            for s2, unit, cosines, turned_before, corners in tx.ways[kind][c]:
                angle = turn(unit, -ahead)
                chord = 2 * np.sin(angle / 2)
                rank = (chord + 0.05) ** 2 * s1 * s2 * (s1 + s2) * np.exp(2 * turned_before + cosines)
                values = common(s1 + s2, tangent) | {
                    4: (turned_before + angle) / np.pi,
                    5: 0.3 * np.log(angle + 0.03),
                    6: 0.3 * np.log(s1 * s2 / (s1 + s2)),
                    7: min(corners, 4) / 4,
                    10: cosines,
                    12: unit @ BISECTOR[c],
                    13: -ahead @ BISECTOR[c],
                }
                ways.append((rank, values))
        ways.sort(key=lambda way: way[0])
        if ways:
            found[kind + 1] = ways[0][1]
        if len(ways) > 1:
            closest_rank[0] = min(closest_rank[0], ways[1][0] / ways[0][0] - 1)
    return found


def link(tx, rx):
    rx = np.array(rx)
    d = size(tx.at - rx)
    direct = overlap(rx[None], tx.at[None], skipping(1, -1))
    note(direct)
    geodesic = d if direct[0] < 0 else np.where(sees(rx, ALL), size(CORNERS - rx) + tx.to_corner, np.inf).min()
    rows = []
    for direction in ROWS:
        angle = (direction + 0.5) * BEAM
        ways = []
        for bounces, segment in enumerate(segments(rx, angle)):
            for kind, values in features(tx, rx, segment, bounces).items():
                ways.append([kind, bounces, [rounded(values.get(f, 0)) for f in range(14)]])
        rows.append({"direction": direction, "ways": ways})
    return {"tx": tx.at.tolist(), "rx": rx.tolist(), "geodesic_m": round(float(geodesic), 9), "rows": rows}


def rounded(value):
    return round(float(value), 6)


transmitters = [Transmitter(tx) for tx in TRANSMITTERS]
links = [link(transmitters[tx], RECEIVERS[rx]) for tx, rx in LINKS]
assert closest_m[0] > CLEAR_M, f"a decision is {closest_m[0]} m from falling the other way: move a terminal"
assert closest_rank[0] > CLEAR_RANK, f"ranks of two ways differ by {closest_rank[0]} of them: move a terminal"
path = Path(__file__).with_name("polar.json")
out = {"city": CITY, "directions": DIRECTIONS, "bounces": BOUNCES, "links": links}
path.write_text(json.dumps(out, separators=(",", ":"), default=float) + "\n")
every = [way for link in links for row in link["rows"] for way in row["ways"]]
counts = np.zeros((5, 3), int)
for kind, bounces, _ in every:
    counts[kind, bounces] += 1
print("closest decision", closest_m[0], "m; closest ranks", closest_rank[0], ";", path.stat().st_size, "bytes; ways by kind and bounces\n", counts)
