"""Scores of predicted spectra."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import USUAL_PROTOCOL, Protocol
from ._dataset import Dataset


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores of a prediction: as a dict, each metric of each scored sample; beside it, what they come to.

    Attributes
    ----------
    values : dict of str to ndarray of float64, shape (scored,)
        Each metric of each sample that could be scored, by its name, which ends with the unit if it has one: ``mae``, ``mse``,
        ``psnr_db``, ``cosine``, ``ple_deg`` (degrees), ``hit_2deg`` (0 or 1), ...
    rows : ndarray of int64, shape (scored,)
        Rows of these samples.
    rejected : ndarray of int64, shape (rejected,)
        Rows that hold NaN, an infinity or a value beyond 1e70: they are in no mean.
    report : dict
        Mean, deviation and quantiles of every metric, overall and by map, with the definition that they follow.
    """

    values: dict[str, npt.NDArray[np.float64]]
    rows: npt.NDArray[np.int64]
    rejected: npt.NDArray[np.int64]
    report: dict[str, Any]

    def __repr__(self) -> str:
        means = ", ".join(f"{name} {mean:.4g}" for name, mean in self.summary.items())
        return f"Scores({len(self.rows)} samples, {len(self.rejected)} rejected; means: {means})"

    @property
    def summary(self) -> dict[str, float]:
        """Mean of each metric over the scored samples, by its name."""
        return {str(of["metric"]): float(of["mean"]) for of in self.report["overall"]["metrics"]}

    def keys(self) -> list[str]:
        """Tells which metrics there are.

        Returns
        -------
        list of str
            Their names.
        """
        return list(self.values)

    def __iter__(self) -> Iterator[str]:
        """The names."""
        return iter(self.values)

    def __len__(self) -> int:
        """Number of metrics."""
        return len(self.values)

    def __contains__(self, metric: object) -> bool:
        """Tells if there is a metric of this name.

        Parameters
        ----------
        metric : object
            The name.

        Returns
        -------
        bool
        """
        return metric in self.values

    def __getitem__(self, metric: str) -> npt.NDArray[np.float64]:
        """Takes a metric of each scored sample.

        Parameters
        ----------
        metric : str
            Its name in ``values``.

        Returns
        -------
        ndarray of float64, shape (scored,)
        """
        return self.values[metric]


def metrics(
    truth: npt.ArrayLike,
    prediction: npt.ArrayLike,
    protocol: Protocol | Dataset = USUAL_PROTOCOL,
    map_ids: npt.ArrayLike | None = None,
    data_range: float | None = None,
) -> Scores:
    """Scores predicted spectra against true ones.

    Parameters
    ----------
    truth, prediction : array_like, shape (samples, bins)
        Spectra in one unit: normalised ones, as learning targets are and the benchmark scores, or linear power; not decibels.
    protocol : {"paper", "released"} or Dataset
        Definition of the metrics, which does not follow from the numbers: give the data set of the true spectra to take that of its
        labels. Numbers of one must not be compared with numbers of the other.
    map_ids : array_like of int, shape (samples,), optional
        Map of each sample, for scores by map.
    data_range : float, optional
        Range that PSNR is relative to; largest minus smallest true value by default.

    Returns
    -------
    Scores

    Warns
    -----
    UserWarning
        For true spectra without a value above 0, as those in decibels.
    """
    if isinstance(protocol, Dataset):
        of_labels = protocol.protocol
        if of_labels is None:
            raise ValueError(f"protocol: {protocol.path} does not tell that of its labels; name it, 'paper' or 'released'")
        protocol = of_labels
    found = _native.metrics(truth, prediction, protocol, map_ids, data_range)
    maximum = found.pop("truth_maximum")
    if maximum is not None and maximum <= 0:
        told = "truth: no value is above 0: metrics are of linear power or of normalised spectra, not of decibels"
        warnings.warn(told, stacklevel=2)
    found["report"] = json.loads(found["report"])
    return Scores(**found)
