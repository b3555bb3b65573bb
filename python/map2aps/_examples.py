"""The labelled links of data sets as models take them."""

from __future__ import annotations

import os
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _native


class Examples:
    """The labelled links of a part of a data set, as conditions and targets of a model; ``len`` counts them.

    A condition of shape (3, size, size) shows buildings, transmitter and receiver, or is the input of Polar-Reg, of shape (ways, 16)
    (see `PolarView`), as many ways as the link of the same batch that has most; a target of shape (180,) is the spectrum as models
    learn it. Conditions are drawn and labels are read as they are asked for, on all cores; where the data set's manifest holds no
    statistics of its labels, as of imported ones, the first normalised target waits until the training maps have been read once.
    ``map2aps.torch.ApsDataset`` gives the same as tensors.

    Parameters
    ----------
    path : path-like
        Folder of the data set.
    split : {"train", "develop", "test"}
        The part; one without labelled links has no examples.
    size : int
        Rows and columns of an image, which shows the whole map whatever its size; anything, None too, where there are no images.
    mirror : bool
        Adds to each link of the training part its images mirrored in x, in y and in both, whose spectra follow without tracing: link
        ``n`` has the numbers ``4 n`` to ``4 n + 3``. The other parts have none. Refused for arrays that are not
        linear, whose data sets need ``mirror=False``.
    domain : {"normalised", "linear"}
        Targets as the benchmark's models learn and are scored on them, or power relative to the link's largest, in [0, 1].
    condition : {"image", "polar"}
        Images, or the input of Polar-Reg.
    maps : path-like, optional
        Folder of RadioMapSeer files or GeoJSON file that the data set was made from: the input of Polar-Reg needs it, unless the maps
        are synthetic.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        split: Literal["train", "develop", "test"] = "train",
        size: int | None = 64,
        mirror: bool = True,
        domain: Literal["normalised", "linear"] = "normalised",
        condition: Literal["image", "polar"] = "image",
        maps: str | os.PathLike[str] | None = None,
    ) -> None:
        if domain not in ("normalised", "linear"):
            raise ValueError(f"domain: '{domain}' is neither 'normalised' nor 'linear'")
        if condition not in ("image", "polar"):
            raise ValueError(f"condition: '{condition}' is neither 'image' nor 'polar'")
        if maps is not None and condition == "image":
            raise ValueError("maps: images are drawn of what the data set holds; only condition='polar' takes maps")
        if size is None and condition == "image":
            raise ValueError("size: None, as of a model that takes no images; Polar-Reg is given condition='polar'")
        settings = {
            "size": 64 if size is None else size,
            "mirror": mirror,
            "linear": domain == "linear",
            "polar": condition == "polar",
            "maps": maps,
        }
        self._opened = (path, split, settings)
        self._examples = _native.Examples(*self._opened)

    def __len__(self) -> int:
        """Number of examples, mirror images among them."""
        return len(self._examples)

    def __repr__(self) -> str:
        path, split, _ = self._opened
        return f"Examples({os.fspath(path)!r}, {split!r}: {len(self)} examples)"

    def batch(self, indices: npt.ArrayLike) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Draws a batch.

        Parameters
        ----------
        indices : array_like of int, shape (n,)
            Numbers of the examples, in any order.

        Returns
        -------
        conditions : ndarray of float32, shape (n, 3, size, size) or (n, ways, 16)
        targets : ndarray of float32, shape (n, 180)

        Raises
        ------
        IndexError
            For a number that no example has; negative ones have none.
        """
        return self._examples.batch(indices)

    @property
    def links(self) -> npt.NDArray[np.int64]:
        """Map, row in it, and rows of transmitter and receiver of each link, without mirror images: shape (links, 4)."""
        return self._examples.links

    # Other processes open the data set anew; whatever a subclass has of its own goes with it.
    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_examples"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._examples = _native.Examples(*self._opened)
