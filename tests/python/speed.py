"""Times the package beside a Rust program of the same calls, in turns, and what PyTorch is fed with: `docs/performance.md`.

    cargo build --release -p map2aps --example many_links
    python tests/python/speed.py path/to/maps/0.json target/release/examples/many_links
    python tests/python/speed.py --data DATA     # opening, loading and batches of a data set; needs PyTorch

Processor time is that of all threads, system and user; wall time depends on what else runs.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np

import map2aps

BATCH = 256


def timed(work: Callable[[], object], who: int = resource.RUSAGE_SELF) -> tuple[float, float]:
    """Processor and wall time in s."""
    used = lambda: sum(resource.getrusage(who)[:2])
    before, started = used(), time.perf_counter()
    work()
    return used() - before, time.perf_counter() - started


def many_links(map_file: str, terminals: np.ndarray) -> None:
    scene = map2aps.Scene.from_radiomapseer(map_file)
    paths = map2aps.Tracer(scene).trace(terminals[:100], terminals[100:])
    assert len(map2aps.label(paths, "released").aps_db) == 50_000


def beside_rust(map_file: str, program: str, rounds: int) -> None:
    grid = np.stack(np.meshgrid(np.arange(257.0), np.arange(257.0)), -1).reshape(-1, 2)
    grid = grid[map2aps.Scene.from_radiomapseer(map_file).is_outdoor(grid)]
    terminals = np.random.default_rng(42).permutation(grid)[:600]
    times: dict[str, list[tuple[float, float]]] = {"Rust": [], "Python": []}
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "terminals.npy")
        np.save(file, terminals)
        rust = lambda: subprocess.run([program, map_file, file], check=True, stdout=subprocess.DEVNULL)
        # Python is a process of its own too, so that no run finds memory that another left; its start and imports are not counted.
        python = [sys.executable, __file__, "--once", map_file, file]
        for _ in range(rounds):
            times["Rust"].append(timed(rust, resource.RUSAGE_CHILDREN))
            found = subprocess.run(python, check=True, stdout=subprocess.PIPE, text=True).stdout.split()
            times["Python"].append((float(found[0]), float(found[1])))
    for who, runs in times.items():
        for unit, values in zip(("processor", "wall"), zip(*runs)):
            print(f"{who:7} {unit:9} [s]: median {np.median(values):.3f} of", *(f"{value:.2f}" for value in values))
    ratio = np.median([cpu for cpu, _ in times["Python"]]) / np.median([cpu for cpu, _ in times["Rust"]])
    print(f"Python costs {100 * (ratio - 1):.1f} % more processor time")


def fed(data: str, links: int) -> None:
    from torch.utils.data import DataLoader

    from map2aps.torch import ApsDataset

    print("opening: %.4f s of processor time, %.4f s" % timed(lambda: map2aps.Dataset(data)), map2aps.Dataset(data))
    kept: list[ApsDataset] = []
    print("loading: %.2f s of processor time, %.2f s" % timed(lambda: kept.append(ApsDataset(data))), len(kept[0]), "examples")
    examples = kept[0]
    order = np.random.default_rng(0).permutation(len(examples))

    def loader() -> None:
        loaded = 0
        for condition, _ in DataLoader(examples, BATCH, shuffle=True, drop_last=True):
            loaded += len(condition)
            if loaded >= links:
                break

    def batches() -> None:
        for first in range(0, links, BATCH):
            examples.batch(order[first : first + BATCH])

    for name, work in (("DataLoader", loader), ("batch", batches), ("DataLoader", loader), ("batch", batches)):
        cpu, wall = timed(work)
        print(f"{name:10}: {links / wall:,.0f} links/s of wall time, {2 * links / cpu:,.0f} for two seconds of processor time")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map_file", nargs="?")
    parser.add_argument("program", nargs="?", help="the example many_links, or with --once its terminals")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--data", help="a data set")
    parser.add_argument("--links", type=int, default=20_480, help="links to draw")
    parser.add_argument("--once", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.once:
        terminals = np.load(args.program)
        print(*timed(lambda: many_links(args.map_file, terminals)))
    elif args.map_file:
        beside_rust(args.map_file, args.program, args.rounds)
    if args.data:
        fed(args.data, args.links)


if __name__ == "__main__":
    main()
