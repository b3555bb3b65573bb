"""Data sets and models for PyTorch.

>>> from torch.utils.data import DataLoader
>>> from map2aps.torch import ApsDataset
>>> loader = DataLoader(ApsDataset("data", "train"), batch_size=256, shuffle=True)  # doctest: +SKIP
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.utils.data import Dataset

from .. import _native

__all__ = ["ApsDataset"]

Example: TypeAlias = tuple[Tensor, Tensor]


class ApsDataset(Dataset[Example]):
    """The labelled links of a part of a data set, as pairs (condition, target); ``len`` and indices count them.

    A condition of shape (3, size, size) shows buildings, transmitter and receiver, or is the input of Polar-Reg, of shape (ways, 16)
    (see `map2aps.PolarView`), as many ways as the link of the same batch that has most; a target of shape (180,) is the spectrum as models
    learn it. Both are float32. Conditions are drawn as they are asked for, a whole batch at once where a DataLoader asks for one, on all
    cores: worker processes are seldom of use.
    Labels stay on disk until they are asked for; where the data set's manifest holds no statistics of them, as of imported ones, the
    first normalised target waits until the training maps have been read once.

    Parameters
    ----------
    path : path-like
        Folder of the data set.
    split : {"train", "develop", "test"}
        The part; one without labelled links has no examples.
    size : int
        Rows and columns of a condition, which shows the whole map whatever its size.
    mirror : bool
        Adds to each link of the training part its images mirrored in x, in y and in both, whose spectra follow without tracing: link
        ``n`` has the numbers ``4 n`` to ``4 n + 3``. The other parts have none. Refused for arrays that are not linear.
    domain : {"normalised", "linear"}
        Targets as the benchmark's models learn them, or power relative to the link's largest, in [0, 1].
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
        size: int = 64,
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
        settings = {
            "size": size,
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

    def __getitem__(self, index: int) -> Example:
        """Draws an example.

        Parameters
        ----------
        index : int
            Its number, from 0 to below ``len``.

        Returns
        -------
        condition : Tensor of float32, shape (3, size, size) or (ways, 16)
        target : Tensor of float32, shape (180,)

        Raises
        ------
        IndexError
            For a number that no example has; negative ones have none.
        """
        return self.__getitems__([index])[0]

    def __getitems__(self, indices: Sequence[int]) -> list[Example]:
        """Draws the examples of a batch at once, as a DataLoader asks for them.

        Parameters
        ----------
        indices : sequence of int
            Their numbers.

        Returns
        -------
        list of tuple (condition, target)
            As `__getitem__` gives them.
        """
        conditions, targets = self.batch(indices)
        return list(zip(conditions, targets))

    def batch(self, indices: npt.ArrayLike) -> Example:
        """Draws a batch.

        Parameters
        ----------
        indices : array_like of int, shape (n,)
            Numbers of the examples, in any order.

        Returns
        -------
        conditions : Tensor of float32, shape (n, 3, size, size) or (n, ways, 16)
        targets : Tensor of float32, shape (n, 180)
        """
        images, targets = self._examples.batch(indices)
        return torch.from_numpy(images), torch.from_numpy(targets)

    @property
    def links(self) -> npt.NDArray[np.int64]:
        """Map, row in it, and rows of transmitter and receiver of each link, without mirror images: shape (links, 4)."""
        return self._examples.links

    # Worker processes open the data set anew; whatever a subclass has of its own goes with it.
    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_examples"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._examples = _native.Examples(*self._opened)
