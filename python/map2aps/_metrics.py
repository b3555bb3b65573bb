"""Scores of predicted spectra."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import USUAL_PROTOCOL, Protocol


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores of a prediction.

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

    @property
    def summary(self) -> dict[str, float]:
        """Mean of each metric over the scored samples, by its name."""
        return {str(of["metric"]): float(of["mean"]) for of in self.report["overall"]["metrics"]}

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
    protocol: Protocol = USUAL_PROTOCOL,
    map_ids: npt.ArrayLike | None = None,
    data_range: float | None = None,
) -> Scores:
    """Scores predicted spectra against true ones.

    Parameters
    ----------
    truth, prediction : array_like, shape (samples, bins)
        Spectra in one unit, as learning targets are.
    protocol : {"released", "paper"}
        Definition of the metrics; numbers of one must not be compared with numbers of the other.
    map_ids : array_like of int, shape (samples,), optional
        Map of each sample, for scores by map.
    data_range : float, optional
        Range that PSNR is relative to; largest minus smallest true value by default.

    Returns
    -------
    Scores
    """
    found = _native.metrics(truth, prediction, protocol, map_ids, data_range)
    found["report"] = json.loads(found["report"])
    return Scores(**found)
