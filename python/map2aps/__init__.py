"""City maps to ray-traced paths to angle power spectra, and data sets of them.

>>> import map2aps
>>> scene = map2aps.Scene.synthetic(seed=1)
>>> paths = map2aps.Tracer(scene).trace((2.0, 2.0), [(30.0, 2.0), (2.0, 40.0)])
>>> map2aps.label(paths).aps_db.shape
(2, 180)

Lengths are metres, times seconds, angles radians counter-clockwise from x unless a name says otherwise (``_db``, ``_deg``). Arguments
are anything that ``numpy.asarray`` accepts; they are copied, and computed with in double precision. Where a function takes a protocol it
is "paper" by default; `relabel` keeps that of the data set.

Python's lock and Ctrl-C:

- `Tracer.trace`, `Tracer.trace_pairs`, `label`, `pdp`, `make_dataset`, `relabel`, `PolarView.ways` and batches of ways of `Examples` work
  without the lock; Ctrl-C ends them.
- Making a `Scene`, `Tracer` or `PolarView`, opening a `Dataset` and `metrics` work without the lock. Ctrl-C raises
  ``KeyboardInterrupt`` at once; the call ends in the background and its result is dropped. The same holds for `Examples` and its
  batches of images.
- `Scene.raster` and `explain` work without the lock. Ctrl-C raises ``KeyboardInterrupt`` when they have ended.
- All else holds the lock: `Scene.is_outdoor` and the attributes of a scene, the arrays of `Paths` and what is made of them, arrays on
  their way in and out.

What works without the lock does so on threads of its own, but for `explain`: as many as there are cores, or as
``RAYON_NUM_THREADS`` says. Results are the same bits for any number of them.

Arrays and numbers of a wrong shape, type or value raise ``ValueError``, an unknown setting or an object of another class
``TypeError``, what the system refuses ``OSError``, a file that is not there ``FileNotFoundError``.
"""

from ._arrays import UniformCircular, UniformLinear
from ._dataset import Dataset, Map, make_dataset, relabel
from ._examples import Examples
from ._explain import Html, explain, plot_link
from ._labels import Labels, Profiles, label, pdp
from ._metrics import Scores, metrics
from ._native import Scene, __version__
from ._paths import Paths, Tracer
from ._polar import PolarView

__all__ = [
    "Dataset",
    "Examples",
    "Html",
    "Labels",
    "Map",
    "Paths",
    "PolarView",
    "Profiles",
    "Scene",
    "Scores",
    "Tracer",
    "UniformCircular",
    "UniformLinear",
    "__version__",
    "explain",
    "label",
    "make_dataset",
    "metrics",
    "pdp",
    "plot_link",
    "relabel",
]
