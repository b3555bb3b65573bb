"""Threads, signals and processes."""

import multiprocessing
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import map2aps
from shapes import answers

MANY = (
    "import map2aps, numpy as np, signal, sys\n"
    # Programs in the background are started with the signal ignored.
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "scene = map2aps.Scene.synthetic(seed=3)\n"
    "tracer = map2aps.Tracer(scene, max_reflections=6, max_diffractions=2, max_interactions=8, dynamic_range_db=None)\n"
    "grid = np.stack(np.meshgrid(np.arange(1.0, 255.0), np.arange(1.0, 255.0)), -1).reshape(-1, 2)\n"
    "rx = grid[scene.is_outdoor(grid)]\n"
    "few = tracer.trace(rx[0], rx[1:3])\n"
    "many = np.arange(500 * 300)\n"
    "paths = map2aps.Paths.from_arrays(np.arange(501) * 300, 1e-12 * many, 1e-5 * many, np.ones(len(many)))\n"
    "try:\n"
    "    print('ready', flush=True)\n"
    "    {call}\n"
    "except KeyboardInterrupt:\n"
    "    print('interrupted', flush=True)\n"
    "    map2aps.label(few)\n"
)


@pytest.mark.skipif(os.name == "nt", reason="there, Ctrl-C goes to a whole console")
@pytest.mark.parametrize(
    "call",
    [
        "tracer.trace(rx[:500], rx[1000:])",
        "map2aps.pdp(paths, delay_points=20000)",
        "map2aps.make_dataset(sys.argv[1], 10, tx_per_map=1000, rx_per_map=1000, progress=None)",
    ],
)
def test_ctrl_c_ends_long_work_and_the_next_call_works(call: str, tmp_path: Path) -> None:
    script = [sys.executable, "-c", MANY.format(call=call), str(tmp_path / "set")]
    with subprocess.Popen(script, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        # Far more work is left than fits before this comes.
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "interrupted\n"
        assert process.wait(timeout=60) == 0


class Interrupted:
    """An argument during whose conversion Ctrl-C comes."""

    def _raise(self, *_: object) -> object:
        raise KeyboardInterrupt

    __array__ = __fspath__ = __float__ = __getitem__ = __index__ = __iter__ = __len__ = __repr__ = _raise  # type: ignore[assignment]


@pytest.mark.parametrize(
    "call",
    [
        lambda scene, x: map2aps.Tracer(scene).trace(x, (1.0, 1.0)),
        lambda scene, x: map2aps.Tracer(scene, frequency_hz=x),
        lambda scene, x: map2aps.Tracer(scene, max_reflections=x),
        lambda scene, x: map2aps.Tracer(scene, material=x),
        lambda scene, x: map2aps.Tracer(scene, material=(x, 1.0)),
        lambda scene, x: map2aps.Scene.from_polygons(x),
        lambda scene, x: map2aps.Scene.from_polygons([x]),
        lambda scene, x: map2aps.Scene.synthetic(seed=x),
        lambda scene, x: map2aps.metrics(x, np.ones((2, 180))),
        lambda scene, x: map2aps.make_dataset("nowhere", x),
        lambda scene, x: map2aps.make_dataset("nowhere", 2, seed=x),
        lambda scene, x: map2aps.make_dataset("nowhere", 2, map_ids=x),
    ],
)
def test_ctrl_c_while_an_argument_is_read_is_not_taken_for_a_wrong_one(
    scene: map2aps.Scene, call: Callable[[map2aps.Scene, Any], object]
) -> None:
    with pytest.raises(KeyboardInterrupt):
        call(scene, Interrupted())


WAITING = (
    "import map2aps, numpy as np, os, signal, sys, threading, traceback\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "scene = map2aps.Scene.synthetic(seed=3)\n"
    "begun, main = threading.Event(), threading.get_ident()\n"
    "def occupy():\n"
    "    map2aps.make_dataset(sys.argv[1], 10, tx_per_map=10**4, rx_per_map=10**4, progress=lambda *_: begun.set())\n"
    "def interrupt():\n"
    "    stack = lambda: [frame.f_code.co_name for frame, _ in traceback.walk_stack(sys._current_frames()[main])]\n"
    "    while 'blocked' not in stack():\n"
    "        pass\n"
    "    os.kill(os.getpid(), signal.SIGINT)\n"
    "def blocked():\n"
    "    {call}\n"
    "threading.Thread(target=occupy, daemon=True).start()\n"
    "begun.wait()\n"
    "threading.Thread(target=interrupt, daemon=True).start()\n"
    "try:\n"
    "    blocked()\n"
    "except KeyboardInterrupt:\n"
    "    os.write(1, b'interrupted')\n"
    "    os._exit(0)\n"
)


@pytest.mark.skipif(os.name == "nt", reason="there, Ctrl-C goes to a whole console")
@pytest.mark.parametrize(
    "call",
    [
        "map2aps.Scene.from_polygons([np.array([(40.0, 40.0), (60.0, 40.0), (60.0, 60.0)])])",
        "map2aps.Tracer(scene)",
        "map2aps.PolarView(scene)",
        "map2aps.metrics(np.ones((2, 180)), np.ones((2, 180)))",
    ],
)
def test_ctrl_c_leaves_work_that_cannot_be_cancelled(call: str, tmp_path: Path) -> None:
    # The one thread has days of other work, so that the call itself never ends.
    found = subprocess.run(
        [sys.executable, "-c", WAITING.format(call=call), str(tmp_path / "set")],
        env={**os.environ, "RAYON_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (found.stdout, found.returncode) == ("interrupted", 0), found.stderr


def test_threads_share_a_tracer(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    tracer = map2aps.Tracer(scene)
    alone = [tracer.trace(tx, outdoors[20:60]).gain for tx in outdoors[:8]]
    with ThreadPoolExecutor(8) as threads:
        at_once = list(threads.map(lambda tx: tracer.trace(tx, outdoors[20:60]).gain, outdoors[:8]))
    assert all(np.array_equal(a, b) for a, b in zip(alone, at_once))


def test_threads_share_paths(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    tracer = map2aps.Tracer(scene)
    alone = tracer.trace(outdoors[:4], outdoors[20:60])
    paths = tracer.trace(outdoors[:4], outdoors[20:60])
    expected = map2aps.label(alone).aps_db
    with ThreadPoolExecutor(8) as threads:
        gains = [threads.submit(lambda: paths.gain) for _ in range(8)]
        labels = [threads.submit(lambda: map2aps.label(paths).aps_db) for _ in range(8)]
        assert all(np.array_equal(gain.result(), alone.gain) for gain in gains)
        assert all(np.array_equal(label.result(), expected, equal_nan=True) for label in labels)


def test_the_number_of_threads_changes_no_bit() -> None:
    script = (
        "import map2aps, hashlib, numpy as np\n"
        "scene = map2aps.Scene.synthetic(seed=3)\n"
        "grid = np.stack(np.meshgrid(np.arange(1.0, 256.0, 16.0), np.arange(1.0, 256.0, 16.0)), -1).reshape(-1, 2)\n"
        "rx = grid[scene.is_outdoor(grid)]\n"
        "paths = map2aps.Tracer(scene).trace(rx[:3], rx[5:])\n"
        "label = map2aps.label(paths)\n"
        "print(hashlib.sha256(paths.gain.tobytes() + label.aps_db.tobytes()).hexdigest())\n"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "RAYON_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "3")
    }
    assert len(found) == 1


def are_same(a: list[np.ndarray], b: list[np.ndarray]) -> bool:
    return len(a) == len(b) and all(np.array_equal(*of, equal_nan=of[0].dtype.kind == "f") for of in zip(a, b))


def test_threads_share_a_scene_and_a_view(outdoors: np.ndarray) -> None:
    def asked(scene: map2aps.Scene, view: map2aps.PolarView) -> list[np.ndarray]:
        paths = map2aps.Tracer(scene).trace(outdoors[0], outdoors[20:30])
        return [scene.raster(64), scene.walls, scene.is_outdoor(outdoors), paths.gain, view.ways(outdoors[0], outdoors[20:24])]

    scenes = [map2aps.Scene.synthetic(seed=3) for _ in range(2)]
    alone = asked(scenes[0], map2aps.PolarView(scenes[0]))
    view = map2aps.PolarView(scenes[1])
    with ThreadPoolExecutor(4) as threads:
        assert all(are_same(alone, found) for found in threads.map(lambda _: asked(scenes[1], view), range(6)))


def test_threads_share_a_data_set_and_score_at_once(data: Path) -> None:
    def asked(dataset: map2aps.Dataset) -> list[np.ndarray]:
        spectra = np.concatenate([one["aps_db"] for one in dataset]).astype(float)
        power = 10.0 ** (spectra / 10.0)
        scores = map2aps.metrics(power, power[::-1])
        return [spectra, dataset.angle_deg, *(one["tx"] for one in dataset), *scores.values.values()]

    alone, dataset = asked(map2aps.Dataset(data)), map2aps.Dataset(data)
    with ThreadPoolExecutor(4) as threads:
        assert all(are_same(alone, found) for found in threads.map(asked, [dataset] * 6))


STARTS = [name for name in ("fork", "forkserver", "spawn") if name in multiprocessing.get_all_start_methods()]


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.filterwarnings("ignore:This process.*multi-threaded:DeprecationWarning")
def test_processes_born_after_the_threads_work_too(start: str) -> None:
    # The parent has its threads by now, which a forked child has not.
    expected = [answers(seed) for seed in (1, 2)]
    with multiprocessing.get_context(start).Pool(2) as pool:
        found = pool.map_async(answers, [1, 2]).get(timeout=120)
    assert all(are_same(a, b) for a, b in zip(expected, found))
    assert are_same(answers(1), expected[0])
