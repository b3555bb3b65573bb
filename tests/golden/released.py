"""Golden files of the published data's formats: released/ beside this script.

Profiles and samples are written by NumPy 2, .propbin files by Python's struct after the published description. The
output is the same each time.
"""

import gzip
import json
import struct
from pathlib import Path

import numpy as np

OUT = Path(__file__).with_name("released")
OUT.mkdir(exist_ok=True)
rng = np.random.default_rng(2026)

# Powers and places in double precision: random ones, ties between two half-precision numbers, and ties missed by a hair.
for name, bins in (("aps", 180), ("pdp", 128)):
    db = -60 - rng.exponential(40, bins)
    place = rng.uniform(-180, 1000, bins)
    half = db[::4].astype(np.float16)
    after = np.nextafter(half, np.float16(0))
    db[::4] = (half.astype(float) + after.astype(float)) / 2 * (1 + rng.choice([-1, 0, 1], len(half)) * 1e-13)
    db[1], place[1] = -350, 0
    (OUT / f"{name}.json").write_text(json.dumps({"db": db.tolist(), "place": place.tolist()}) + "\n")
    np.save(OUT / f"{name}.npy", np.stack((db, place), axis=1).astype(np.float16))

np.savez_compressed(
    OUT / "sample.npz",
    aps_norm=rng.normal(size=180).astype(np.float32),
    cond_img=(np.arange(3 * 8 * 4).reshape(3, 8, 4) / 96).astype(np.float32),
)

# Two receivers, the second without a path; three paths whose numbers half precision holds exactly.
source, receivers = (10.0, 20.0, 1.5), [(7, (30.0, 20.0, 1.5), -60.5, 61.5, 3), (-1, (40.0, 25.0, 1.5), float("-inf"), float("inf"), 0)]
paths = [  # loss, length, delay, departure az and el, arrival az and el
    (61.5, 20.0, 66.75, 0.0, 0.0, 0.0, 0.0),
    (80.25, 35.5, 118.5, 1.25, 0.5, -2.5, -0.5),
    (95.0, 50.0, 166.75, -1.5, 0.25, 3.0, 0.125),
]


def head(version, entries):
    return struct.pack("<II3fIII", 0x50524F50, version, *source, len(receivers), len(paths), entries)


def receiver_table():
    first, table = 0, b""
    for number, place, power, loss, n in receivers:
        table += struct.pack("<i3f2fHHI", number, *place, power, loss, n, 0, first)
        first += n
    return table


chains = [
    [source, (30.0, 20.0, 1.5)],
    [source, (20.0, 35.0, 1.5), (30.0, 20.0, 1.5)],
    [source, (12.5, 0.0, 1.5), (28.0, 2.0, 1.5), (30.0, 20.0, 1.5)],
]
full, first = head(1, sum(map(len, chains))) + receiver_table(), 0
for (loss, length, delay, *angles), chain in zip(paths, chains):
    full += struct.pack("<7fHHI", loss, length, *angles, delay, len(chain), 0, first)
    first += len(chain)
for point in sum(chains, []):
    full += struct.pack("<3f", *point)
(OUT / "full.propbin").write_bytes(full)

roof = np.array([[14.5, 21.0], [25.0, 20.5]], np.float16)
words = [[], [3, 700], roof.view(np.uint16).ravel().tolist()]
compact, first = head(2, sum(map(len, words))) + receiver_table(), 0
for path, chain, kind in zip(paths, words, (0, 2, -1)):
    compact += np.array(path, np.float16).tobytes() + struct.pack("<HbBHI", len(chain), kind, 0, 0, first)
    first += len(chain)
compact += struct.pack(f"<{first}H", *sum(words, []))
(OUT / "compact.propbin.gz").write_bytes(gzip.compress(compact, mtime=0))
