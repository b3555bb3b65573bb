"""Data sets and models for PyTorch.

>>> from torch.utils.data import DataLoader
>>> from map2aps.torch import ApsDataset
>>> loader = DataLoader(ApsDataset("data", "train"), batch_size=256, shuffle=True)  # doctest: +SKIP
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.utils.data import Dataset

from .._examples import Examples

__all__ = ["ApsDataset"]

Example: TypeAlias = tuple[Tensor, Tensor]


class ApsDataset(Dataset[Example]):
    """The labelled links of a part of a data set, as pairs (condition, target) of tensors; ``len`` and indices count them.

    It is `map2aps.Examples` for PyTorch, which says what they are. A whole batch is drawn at once where a DataLoader asks for one, on all
    cores: worker processes are seldom of use, and open the data set anew.

    Parameters
    ----------
    path, split, size, mirror, domain, condition, maps
        See `map2aps.Examples`.
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
        self._examples = Examples(path, split, size, mirror, domain, condition, maps)

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
