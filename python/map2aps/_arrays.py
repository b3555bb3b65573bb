"""Receiving arrays, and the settings of labels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

Protocol: TypeAlias = Literal["paper", "released"]
# Of every function that takes one, as of ``cargo xtask dataset``.
USUAL_PROTOCOL: Protocol = "paper"


@dataclass(frozen=True)
class UniformLinear:
    """Equally spaced elements on the y axis, which see an angle theta and pi - theta alike.

    Parameters
    ----------
    elements : int
        Number of elements, 1 to 4096.
    spacing_wavelengths : float
        Distance of neighbours in wavelengths, above 0.
    """

    elements: int = 16
    spacing_wavelengths: float = 0.5


@dataclass(frozen=True)
class UniformCircular:
    """Elements on a circle, the first towards x.

    Parameters
    ----------
    elements : int
        Number of elements, 1 to 4096.
    radius_wavelengths : float
        Radius of the circle in wavelengths, above 0.
    """

    elements: int
    radius_wavelengths: float


Array: TypeAlias = UniformLinear | UniformCircular


def label_settings(
    protocol: Protocol,
    array: Array | None,
    sampling_rate_hz: float | None,
    delay_points: int | None = None,
    last_delay_s: float | None = None,
) -> dict[str, Any]:
    """Settings of labels as the native module takes them; None is the protocol's own."""
    if not (array is None or isinstance(array, UniformLinear | UniformCircular)):
        raise TypeError(f"array: expected UniformLinear or UniformCircular, got {type(array).__name__}")
    return {
        "protocol": protocol,
        "array": array,
        "sampling_rate_hz": sampling_rate_hz,
        "delay_points": delay_points,
        "last_delay_s": last_delay_s,
    }
