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
            Ways that arrive along 720 rays from the receiver, links in the order of `Tracer.trace`. A way has 14 features, the number of
            its ray and the number of its kind. Rays are half a degree apart; the first is a quarter of a degree from x. There are 15 kinds:
            straight, and over corners by how these are lit, each after 0, 1 and 2 reflections. Zeros fill the rows of links that have
            fewer ways than others. Rust's documentation of ``aps_raytrace::polar::PolarLink`` defines the features; all are without unit.
        """
        return self._view.ways(tx, rx)
