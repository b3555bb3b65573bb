"""Paths and time of the tracer beside Sionna RT on the same links; see README.md beside this file.

    python beside_sionna.py RUNNER MAP.json [--tx 20] [--rx 50] [--samples 1e4 1e5 1e6] [--rounds 3] ...

RUNNER is a release build of xtask. Prints tables in Markdown.
"""

import argparse
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import compare
import extrusion

LIGHT_M_S = 299_792_458.0
HEIGHT_M, TERMINAL_M, SAME_HEIGHT_M = 25.0, 1.5, 1e-3
FREQUENCY_HZ = 3.5e9
REPEATS = 10
MODES = {"R<=3": 0, "R<=3, D<=1, 3 in all": 1}


def cpu_s(who):
    return resource.getrusage(who).ru_utime


class Ours:
    """Runs the runner's `dataset` on one map and reads the paths it stored."""

    def __init__(self, runner, map_file, tx, rx, material, folder):
        map_file = Path(map_file)
        self.folder = Path(folder) / "dataset"
        self.command = [
            runner, "dataset", "--maps", map_file.parent, "--map-ids", map_file.stem, "--tx-per-map", tx, "--rx-per-map", rx,
            "--max-reflections", 3, "--max-interactions", 3, "--max-fallback-diffractions", 0, "--no-prune", "--material", material,
            "--frequency-hz", int(FREQUENCY_HZ), "--store", "paths", "--out", self.folder,
        ]  # fmt: skip

    def run(self, diffractions, threads):
        """Wall time and user CPU time [s] of the whole process, means of some runs: one is as short as the clock's tick."""
        command = [str(part) for part in [*self.command, "--max-diffractions", diffractions, "--threads", threads]]
        cpu, wall = cpu_s(resource.RUSAGE_CHILDREN), 0.0
        for _ in range(REPEATS):
            shutil.rmtree(self.folder, ignore_errors=True)
            start = time.perf_counter()
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            wall += time.perf_counter() - start
        return wall / REPEATS, (cpu_s(resource.RUSAGE_CHILDREN) - cpu) / REPEATS

    def array(self, name):
        return np.load(next(self.folder.glob("map_*")) / f"{name}.npy")

    def paths(self):
        """Paths of each link, by (transmitter, receiver)."""
        names = "path_offset path_delay_s path_departure_azimuth_rad path_arrival_azimuth_rad path_gain"
        offset, delay, departure, arrival, gain = (self.array(name) for name in names.split())
        first, kind, point = (self.array(f"interaction_{name}") for name in ("offset", "kind", "point"))
        links = {}
        for link, ends in enumerate(zip(self.array("link_tx"), self.array("link_rx"))):
            links[tuple(map(int, ends))] = [
                compare.Path(
                    "".join("RD"[k] for k in kind[first[p] : first[p + 1]]), delay[p] * LIGHT_M_S, departure[p], arrival[p],
                    20 * np.log10(abs(gain[p])), point[first[p] : first[p + 1]],
                )
                for p in range(offset[link], offset[link + 1])
            ]  # fmt: skip
        return links


class Peer:
    """Traces the same links with Sionna RT, some transmitters a call."""

    def __init__(self, scene_file, tx, rx, deterministic):
        # Its kernels are cached in the home folder: an empty one makes the first call what it is on a new machine.
        os.environ["HOME"] = str(scene_file.parent)
        import drjit
        import sionna.rt

        self.rt, self.drjit, self.tx = sionna.rt, drjit, tx
        self.scene = sionna.rt.load_scene(str(scene_file))
        self.scene.frequency = FREQUENCY_HZ
        antenna = sionna.rt.PlanarArray(num_rows=1, num_cols=1, pattern="iso", polarization="V")
        self.scene.tx_array = self.scene.rx_array = antenna
        for r, (x, y) in enumerate(rx):
            self.scene.add(sionna.rt.Receiver(f"rx{r}", [float(x), float(y), TERMINAL_M]))
        self.solver = sionna.rt.PathSolver(deterministic=deterministic)

    def calls(self, samples):
        """Groups of transmitters that one call takes: at most a million samples, for the sake of memory."""
        size = max(1, int(1e6 // samples))
        return [range(first, min(first + size, len(self.tx))) for first in range(0, len(self.tx), size)]

    def call(self, group, samples, diffractions, keep=None):
        """Wall time and user CPU time [s] of tracing the group's links; their paths go into `keep`, outside of the time."""
        for t in group:
            x, y = self.tx[t]
            self.scene.add(self.rt.Transmitter(f"tx{t}", [float(x), float(y), TERMINAL_M]))
        cpu, wall = cpu_s(resource.RUSAGE_SELF), time.perf_counter()
        paths = self.solver(
            self.scene, max_depth=3, samples_per_src=samples, max_num_paths_per_src=samples, refraction=False,
            diffraction=diffractions > 0,
        )  # fmt: skip
        self.drjit.eval(paths.a, paths.tau)
        self.drjit.sync_thread()
        spent = np.array([time.perf_counter() - wall, cpu_s(resource.RUSAGE_SELF) - cpu])
        for t in group:
            self.scene.remove(f"tx{t}")
        if keep is not None:
            self.read(paths, group, keep)
        return spent

    def read(self, paths, group, links):
        """Store each link's paths in the plane of the terminals into `links`, and under None how many leave the plane."""
        valid, tau, kinds, points = (v.numpy() for v in (paths.valid, paths.tau, paths.interactions, paths.vertices))
        level_db = 20 * np.log10(np.abs(paths.a[0].numpy() + 1j * paths.a[1].numpy())[:, 0, :, 0] + 1e-30)
        departure, arrival = paths.phi_t.numpy(), paths.phi_r.numpy()
        for r, t in np.ndindex(valid.shape[:2]):
            found = links.setdefault((group[t], r), [])
            for p in np.flatnonzero(valid[r, t]):
                kind = kinds[:, r, t, p]
                there = points[kind != 0, r, t, p]
                if np.any(np.abs(there[:, 2] - TERMINAL_M) > SAME_HEIGHT_M):
                    links[None] = links.get(None, 0) + 1
                    continue
                sequence = "".join({1: "R", 8: "D"}[int(k)] for k in kind[kind != 0])
                found.append(
                    compare.Path(
                        sequence, tau[r, t, p] * LIGHT_M_S, departure[r, t, p], arrival[r, t, p], level_db[r, t, p], there[:, :2]
                    )
                )

    def run(self, samples, diffractions, keep=None):
        """Wall time and user CPU time [s] of all links."""
        return sum(self.call(group, samples, diffractions, keep) for group in self.calls(samples))


def spread(values, unit):
    """Median and range of some measurements, as text."""
    values = [value / unit for value in values]
    return f"{statistics.median(values):.3g} ({min(values):.3g} to {max(values):.3g})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runner")
    parser.add_argument("map")
    parser.add_argument("--tx", type=int, default=20)
    parser.add_argument("--rx", type=int, default=50)
    parser.add_argument("--samples", type=float, nargs="+", default=[1e4, 1e5, 1e6], help="samples a transmitter")
    parser.add_argument("--rounds", type=int, default=3, help="both sides in turns, for their time; paths are compared in the first")
    parser.add_argument("--material", choices=["concrete", "pec"], default="concrete")
    parser.add_argument("--thickness", type=float, default=10.0, help="of the peer's walls [m]; the tracer's are half spaces")
    parser.add_argument("--no-caps", action="store_true", help="leave roofs and floors out of the peer's scene")
    parser.add_argument("--not-deterministic", action="store_true", help="let the peer use its other generator of candidates")
    args = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        footprints = extrusion.united(args.map)
        peer_material = {"concrete": "concrete", "pec": "metal"}[args.material]
        scene = extrusion.write_scene(folder, footprints, HEIGHT_M, not args.no_caps, peer_material, args.thickness)
        ours = Ours(args.runner, args.map, args.tx, args.rx, args.material, folder)
        ours.run(0, 1)
        tx, rx = ours.array("tx"), ours.array("rx")
        peer = Peer(scene, tx, rx, not args.not_deterministic)
        ends, corners = lambda link: (tx[link[0]], rx[link[1]]), compare.outlines(footprints)
        links = args.tx * args.rx
        print(f"{len(corners)} walls, {links} links, {vars(args)}\n")

        sizes, threads = [int(samples) for samples in args.samples], os.cpu_count()
        first_s, times = {}, {}
        for turn in range(args.rounds):
            for mode, diffractions in MODES.items():
                for samples in sizes:
                    for count in sorted({1, threads}):
                        times.setdefault((mode, -count), []).append(ours.run(diffractions, count))
                    peer_paths = None if turn else {}
                    if turn == 0:
                        first_s[mode, samples] = peer.call(peer.calls(samples)[0], samples, diffractions)[0]
                    times.setdefault((mode, samples), []).append(peer.run(samples, diffractions, peer_paths))
                    print(turn, mode, samples, *(times[mode, key][-1] for key in (samples, -threads)), file=sys.stderr, flush=True)
                    if turn == 0:
                        compare.report(f"{mode}, {samples:.0e} samples", ours.paths(), peer_paths, ends, corners)

        print(f"| limits | who | wall time a link [us] | user CPU time a link [us] | first call [s] |\n|{'---|' * 5}")
        for (mode, size), spent in sorted(times.items()):
            who = f"peer, {size:.0e} samples" if size > 0 else f"ours, {-size} threads, whole process"
            wall, cpu = (spread([s[k] for s in spent], links * 1e-6) for k in range(2))
            first = f"{first_s[mode, size]:.1f}" if size > 0 else "-"
            print(f"| {mode} | {who} | {wall} | {cpu} | {first} |")


if __name__ == "__main__":
    main()
