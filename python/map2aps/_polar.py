"""The input of the model Polar-Reg."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _native


class PolarView:
    """Shows a city to its receivers along rays: the input of the model Polar-Reg, which knows no field strength.

    Parameters
    ----------
    scene : Scene
        The buildings.

    Attributes
    ----------
    scene : Scene
    """

    def __init__(self, scene: _native.Scene) -> None:
        self.scene = scene
        self._view = _native.PolarView(scene)

    def ways(self, tx: npt.ArrayLike, rx: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """Finds the ways of the links from each transmitter to each receiver. Some 20 kB a link: take some thousand at a time.

        Parameters
        ----------
        tx : array_like, shape (2,) or (m, 2)
            Transmitters in m, outdoors.
        rx : array_like, shape (2,) or (n, 2)
            Receivers in m, outdoors.

        Returns
        -------
        ndarray of float32, shape (m * n, ways, 16)
            By link, in the order of `Tracer.trace`, the ways that arrive along 720 rays from the receiver: of each 14 features, the number
            of its ray, half a degree apart, the first a quarter of one from x, and that of its kind, of 15 (straight, and over corners by how they
            are lit; each after 0, 1 and 2 reflections). Links of fewer ways than others end with ways of zeros. Rust's documentation
            of ``aps_raytrace::polar::PolarLink`` defines the features; all are without unit.
        """
        return self._view.ways(tx, rx)
