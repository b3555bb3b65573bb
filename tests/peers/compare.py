"""Paths of two tracers on the same links, matched and counted."""

import itertools
from dataclasses import dataclass

import numpy as np

LENGTH_M, ANGLE_DEG, TOUCH_M = 0.01, 0.2, 1e-3


@dataclass
class Path:
    sequence: str
    length_m: float
    departure_rad: float
    arrival_rad: float
    level_db: float
    points: np.ndarray  # (interactions, 2) [m]


def apart(one, other):
    """Largest of the differences of two paths, in parts of what still counts as equal."""
    turns = [one.departure_rad - other.departure_rad, one.arrival_rad - other.arrival_rad]
    degrees = [abs(np.degrees((turn + np.pi) % (2 * np.pi) - np.pi)) for turn in turns]
    return max(abs(one.length_m - other.length_m) / LENGTH_M, max(degrees) / ANGLE_DEG)


def match(ours, peers):
    """Pairs of equal paths, nearest first, each path once; and the rest of both."""
    pairs = sorted(
        (distance, i, j)
        for (i, one), (j, other) in itertools.product(enumerate(ours), enumerate(peers))
        if one.sequence == other.sequence and (distance := apart(one, other)) <= 1
    )
    mine, theirs, both = set(), set(), []
    for _, i, j in pairs:
        if i not in mine and j not in theirs:
            mine.add(i), theirs.add(j), both.append((ours[i], peers[j]))
    left = lambda paths, used: [path for k, path in enumerate(paths) if k not in used]
    return both, left(ours, mine), left(peers, theirs)


def touches(path, ends, corners):
    """True where a leg of the path passes a corner, other than one it bends at, within a millimetre."""
    line = np.array([ends[0], *path.points, ends[1]])
    for a, b in itertools.pairwise(line):
        leg = b - a
        along = np.clip((corners - a) @ leg / max(leg @ leg, 1e-12), 0, 1)
        near = np.linalg.norm(a + along[:, None] * leg - corners, axis=1) < TOUCH_M
        bends = (np.linalg.norm(corners[:, None] - path.points[None], axis=2) < TOUCH_M).any(1) if len(path.points) else False
        if np.any(near & ~bends):
            return True
    return False


def kind(sequence):
    return {"": "direct"}.get(sequence, "R and D mixed" if len(set(sequence)) > 1 else sequence)


def outlines(footprints):
    """Corners (N, 2) [m] of footprints."""
    return np.array([point for part in footprints for ring in [part.exterior, *part.interiors] for point in ring.coords[:-1]])


def report(title, ours, peers, ends, corners):
    """Print what both found, by kind of path; `ends` are the positions [m] of a link's ends."""
    rows, shares, peer_shares = {}, [], []
    for link, mine in ours.items():
        theirs = peers.get(link, [])
        both, missed, extra = match(mine, theirs)
        power = lambda paths: sum(10 ** (path.level_db / 10) for path in paths)
        if mine:
            shares.append(power(one for one, _ in both) / power(mine))
        if theirs:
            peer_shares.append(power(other for _, other in both) / power(theirs))
        twice = [path for path in extra if any(path.sequence == other.sequence and apart(path, other) <= 1 for _, other in both)]
        for column, paths in {
            "ours": mine, "peer": theirs, "both": [one for one, _ in both],
            "missed, at a corner": [path for path in missed if touches(path, ends(link), corners)],
            "extra, at a corner": [path for path in extra if touches(path, ends(link), corners)],
            "extra, twice": twice,
        }.items():  # fmt: skip
            for path in paths:
                row = rows.setdefault(kind(path.sequence), {})
                row[column] = row.get(column, 0) + 1
        for one, other in both:
            rows[kind(one.sequence)].setdefault("differences", []).append(other.level_db - one.level_db)
    print(f"{title}; {peers.get(None, 0)} paths of the peer leave the plane\n")
    columns = ["ours", "peer", "both", "missed, at a corner", "extra, at a corner", "extra, twice"]
    print(f"| paths | {' | '.join(columns)} | the peer found | level, peer - ours [dB]: median, 5 % to 95 % |\n|{'---|' * (len(columns) + 3)}")
    for name, row in sorted(rows.items(), key=lambda item: (len(item[0]), item[0])):
        counts = [row.get(column, 0) for column in columns]
        level = "-"
        if "differences" in row:
            low, middle, high = np.percentile(row["differences"], [5, 50, 95])
            level = f"{middle:.2g}, {low:.2g} to {high:.2g}"
        found = f"{100 * row.get('both', 0) / row['ours']:.1f} %" if "ours" in row else "-"
        print(f"| {name} | {' | '.join(map(str, counts))} | {found} | {level} |")
    print(f"\nPower of a link's paths, mean of {len(shares)} links: {100 * np.mean(shares):.2f} % of ours is of paths the peer has too;")
    print(f"mean of {len(peer_shares)} links: {100 * np.mean(peer_shares):.2f} % of the peer's is of paths ours has too.\n", flush=True)
