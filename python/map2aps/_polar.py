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

    def input(self, tx: npt.ArrayLike, rx: npt.ArrayLike) -> npt.NDArray[np.float32]:
        """Finds the geometry of the links from each transmitter to each receiver. 151 kB a link: take some hundred at a time.

        Parameters
        ----------
        tx : array_like, shape (2,) or (m, 2)
            Transmitters in m, outdoors.
        rx : array_like, shape (2,) or (n, 2)
            Receivers in m, outdoors.

        Returns
        -------
        ndarray of float32, shape (m * n, 180, 210)
            By link, in the order of `Tracer.trace`, and direction at the receiver, 2 degrees apart, the first a degree from x: 14
            features of each of 15 ways (straight, and over corners by how they are lit; each after 0, 1 and 2 reflections). Rust's
            documentation of ``aps_raytrace::polar::PolarLink`` defines them; all are without unit.
        """
        return self._view.input(tx, rx)
