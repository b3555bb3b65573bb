"""Angle power spectra and power delay profiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import USUAL_PROTOCOL, Array, Protocol, label_settings
from ._paths import Paths, held


@dataclass(frozen=True, eq=False)
class Labels:
    """Angle power spectra of links.

    Attributes
    ----------
    aps_db : ndarray of float64, shape (links, 180)
        Power over azimuth in dB ("paper": relative to the power sent; "released": dBm, 1 dBm sent); NaN for a link without a label.
    angle_deg : ndarray of float64, shape (180,)
        Azimuth of each bin; in "released" the direction of travel, half a turn from where a path comes from.
    is_labelled : ndarray of bool, shape (links,)
        False for links without a path that the protocol counts.
    """

    aps_db: npt.NDArray[np.float64]
    angle_deg: npt.NDArray[np.float64]
    is_labelled: npt.NDArray[np.bool_]

    def __repr__(self) -> str:
        return f"Labels({len(self.aps_db)} links, {np.count_nonzero(self.is_labelled)} labelled, {len(self.angle_deg)} angles)"


@dataclass(frozen=True, eq=False)
class Profiles:
    """Power delay profiles of links.

    Attributes
    ----------
    pdp_db : ndarray of float64, shape (links, delays)
        Power over delay in dB ("paper": relative to the power sent; "released": dBm, 1 dBm sent); NaN for a link without a label.
    delay_s : ndarray of float64, shape (delays,)
        Delay of each point in s.
    is_labelled : ndarray of bool, shape (links,)
        False for links without a path that the protocol counts.
    """

    pdp_db: npt.NDArray[np.float64]
    delay_s: npt.NDArray[np.float64]
    is_labelled: npt.NDArray[np.bool_]

    def __repr__(self) -> str:
        return f"Profiles({len(self.pdp_db)} links, {np.count_nonzero(self.is_labelled)} labelled, {len(self.delay_s)} delays)"


def label(
    paths: Paths,
    protocol: Protocol = USUAL_PROTOCOL,
    array: Array | None = None,
    sampling_rate_hz: float | None = None,
) -> Labels:
    """Makes the angle power spectrum of each link.

    Parameters
    ----------
    paths : Paths
        Paths of any number of links.
    protocol : {"paper", "released"}
        Definition of the label.
    array : UniformLinear or UniformCircular, optional
        The receiving array; 16 elements half a wavelength apart by default.
    sampling_rate_hz : float, optional
        Bandwidth-related sampling rate in Hz; 200e6 by default.

    Returns
    -------
    Labels
        One spectrum for each link.
    """
    found = _native.label(held(paths), label_settings(protocol, array, sampling_rate_hz), False)
    return Labels(**found)


def pdp(
    paths: Paths,
    protocol: Protocol = USUAL_PROTOCOL,
    array: Array | None = None,
    sampling_rate_hz: float | None = None,
    delay_points: int | None = None,
    last_delay_s: float | None = None,
) -> Profiles:
    """Makes the power delay profile of each link.

    Parameters
    ----------
    paths, protocol, array, sampling_rate_hz
        See `label`.
    delay_points : int, optional
        Number of delays from 0 to `last_delay_s`; 128 in "released", 401 in "paper".
    last_delay_s : float, optional
        The last delay in s; 1e-6 by default.

    Returns
    -------
    Profiles
        One profile for each link.
    """
    settings = label_settings(protocol, array, sampling_rate_hz, delay_points, last_delay_s)
    found = _native.label(held(paths), settings, True)
    return Profiles(pdp_db=found["pdp_db"], delay_s=found["delay_s"], is_labelled=found["is_labelled"])
