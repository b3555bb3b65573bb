"""City maps to ray-traced paths to angle power spectra, and data sets of them.

>>> import map2aps
>>> scene = map2aps.Scene.synthetic(seed=1)
>>> paths = map2aps.Tracer(scene).trace((2.0, 2.0), [(30.0, 2.0), (2.0, 40.0)])
>>> map2aps.label(paths, protocol="paper").aps_db.shape
(2, 180)

Lengths are metres, times seconds, angles radians counter-clockwise from x unless a name says otherwise (``_db``, ``_deg``). Every
function takes anything that NumPy makes an array of, copies it, and computes in double precision on all cores without Python's
lock; Ctrl-C ends it, or, where it cannot stop inside (making scenes and tracers, scores, batches), leaves it to be done unheard.
Results are the same bits for any number of threads, which ``RAYON_NUM_THREADS`` limits. Where a function takes a protocol it is
"released" by default.

Arrays and numbers of a wrong shape, type or value raise ``ValueError``, an unknown setting or an object of another class
``TypeError``, what the system refuses ``OSError``, a file that is not there ``FileNotFoundError``.
"""

from ._arrays import UniformCircular, UniformLinear
from ._dataset import Dataset, Map, make_dataset
from ._explain import Html, explain, plot_link
from ._labels import Labels, Profiles, label, pdp
from ._metrics import Scores, metrics
from ._native import Scene
from ._paths import Paths, Tracer
from ._polar import PolarView

__all__ = [
    "Dataset",
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
    "explain",
    "label",
    "make_dataset",
    "metrics",
    "pdp",
    "plot_link",
]
