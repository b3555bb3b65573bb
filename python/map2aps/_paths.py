"""Paths of links, and the tracer that finds them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, Literal, TypedDict, TypeVar

import numpy as np
import numpy.typing as npt

from . import _native

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Limits(TypedDict, total=False):
    """Settings of a trace, as `Tracer` lists them."""

    limits: Literal["converged", "r2d1"]
    frequency_hz: float
    material: str | tuple[float, float]
    max_reflections: int
    max_diffractions: int
    max_interactions: int
    slope_diffraction: bool
    dynamic_range_db: float | None
    max_fallback_diffractions: int
    max_images: int
    max_wave_bytes: int


T = TypeVar("T", bound=np.generic)


class Column(Generic[T]):
    """An array of `Paths`: made when it is first asked for, and kept."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, paths: Paths | None, owner: type) -> npt.NDArray[T]:
        if paths is None:
            return self  # type: ignore[return-value]
        if self._name not in paths._arrays:
            array = paths._held.column(self._name)
            array.flags.writeable = False
            paths._arrays[self._name] = array
        return paths._arrays[self._name]

    def __set__(self, paths: Paths, value: object) -> None:
        raise AttributeError(f"Paths do not change; make others by replace({self._name}=...)")


class Paths:
    """Paths of links as flat arrays: those of the first link first, and in a link from the shortest.

    The paths of link ``i`` are rows ``path_offset[i]`` to ``path_offset[i + 1]``, the interactions of path ``k``, from transmitter to
    receiver, rows ``interaction_offset[k]`` to ``interaction_offset[k + 1]``.

    The tracer's own numbers stay in its memory: an array is a read-only copy, made when it is first asked for, and `replace` makes
    paths of other numbers. ``paths[i]`` and ``paths[i:j]`` are those of one link and of some, ``len(paths)`` is the number of links.

    Parameters
    ----------
    **columns : array_like
        All of the attributes, by name; `from_arrays` needs fewer.

    Attributes
    ----------
    path_offset : ndarray of int64, shape (links + 1,)
    delay_s : ndarray of float64, shape (paths,)
        Length over the speed of light, in s.
    departure_azimuth_rad : ndarray of float64, shape (paths,)
        From the transmitter to the first interaction, or to the receiver, in (-pi, pi].
    arrival_azimuth_rad : ndarray of float64, shape (paths,)
        From the receiver to the last interaction, or to the transmitter, in (-pi, pi].
    gain : ndarray of complex128, shape (paths,)
        Amplitude between isotropic antennas; its squared magnitude is the power gain.
    interaction_offset : ndarray of int64, shape (paths + 1,)
    interaction_kind : ndarray of uint8, shape (interactions,)
        0 for a reflection, 1 for a diffraction, 255 where it is not known.
    interaction_id : ndarray of uint32, shape (interactions,)
        Wall of the scene, or corner, which is the start of the wall of its number.
    interaction_point_m : ndarray of float64, shape (interactions, 2)
    tx_m, rx_m : ndarray of float64, shape (links, 2)
        Ends of the links in m; NaN where they are not known.
    """

    path_offset = Column[np.int64]()
    delay_s = Column[np.float64]()
    departure_azimuth_rad = Column[np.float64]()
    arrival_azimuth_rad = Column[np.float64]()
    gain = Column[np.complex128]()
    interaction_offset = Column[np.int64]()
    interaction_kind = Column[np.uint8]()
    interaction_id = Column[np.uint32]()
    interaction_point_m = Column[np.float64]()
    tx_m = Column[np.float64]()
    rx_m = Column[np.float64]()

    def __init__(self, **columns: npt.ArrayLike) -> None:
        _known(columns)
        self._hold(_native.Paths(columns))

    def _hold(self, held: _native.Paths) -> Paths:
        self._held, self._arrays = held, dict[str, npt.NDArray[Any]]()
        return self

    @classmethod
    def _of(cls, held: _native.Paths) -> Paths:
        return cls.__new__(cls)._hold(held)

    @classmethod
    def from_arrays(
        cls,
        path_offset: npt.ArrayLike,
        delay_s: npt.ArrayLike,
        arrival_azimuth_rad: npt.ArrayLike,
        gain: npt.ArrayLike,
    ) -> Paths:
        """Paths of another program, as far as labels need them.

        Parameters
        ----------
        path_offset : array_like of int, shape (links + 1,)
            First path of each link, from 0, and the number of paths.
        delay_s : array_like, shape (paths,)
            Delay in s.
        arrival_azimuth_rad : array_like, shape (paths,)
            From the receiver to the last interaction, in rad.
        gain : array_like, shape (paths,)
            Complex amplitude, or its magnitude; linear.

        Returns
        -------
        Paths
            Their departure is 0, they have no interactions, and their ends are NaN.
        """
        paths, nowhere = np.size(delay_s), np.full((max(np.size(path_offset) - 1, 0), 2), np.nan)
        return cls(
            path_offset=path_offset,
            delay_s=delay_s,
            departure_azimuth_rad=np.zeros(paths),
            arrival_azimuth_rad=arrival_azimuth_rad,
            gain=gain,
            interaction_offset=np.zeros(paths + 1, dtype=np.int64),
            interaction_kind=np.zeros(0, dtype=np.uint8),
            interaction_id=np.zeros(0, dtype=np.uint32),
            interaction_point_m=np.zeros((0, 2)),
            tx_m=nowhere,
            rx_m=nowhere,
        )

    def replace(self, **columns: npt.ArrayLike) -> Paths:
        """Makes paths that have other arrays in place of some.

        Parameters
        ----------
        **columns : array_like
            The other arrays, by the names of the attributes.

        Returns
        -------
        Paths
        """
        _known(columns)
        return Paths._of(_native.Paths(self._columns() | columns, self._held.digest))

    __replace__ = replace

    def _columns(self) -> dict[str, npt.ArrayLike]:
        return {name: getattr(self, name) for name in COLUMNS}

    def __getstate__(self) -> tuple[dict[str, npt.ArrayLike], str | None]:
        return self._columns(), self._held.digest

    def __setstate__(self, state: tuple[dict[str, npt.ArrayLike], str | None]) -> None:
        self._hold(_native.Paths(*state))

    def __len__(self) -> int:
        """Number of links."""
        return len(self._held)

    def __repr__(self) -> str:
        return f"Paths({len(self)} links, {self._held.count} paths)"

    def __getitem__(self, link: int | slice) -> Paths:
        """Takes the paths of a link, or of some.

        Parameters
        ----------
        link : int or slice
            Number of the link, from the end if negative, or a range of them.

        Returns
        -------
        Paths
            Of one link, or of those in the range.

        Raises
        ------
        IndexError
            For a number that no link has.
        """
        try:
            found = range(len(self))[link]
        except IndexError:
            raise IndexError(f"link: {link} is none of {len(self)} links") from None
        return Paths._of(self._held.take(found if isinstance(found, range) else [found]))

    @property
    def gain_db(self) -> npt.NDArray[np.float64]:
        """Power gain of each path in dB, shape (paths,): minus its path loss; -inf for a gain of 0."""
        with np.errstate(divide="ignore"):
            return np.asarray(20.0 * np.log10(np.abs(self.gain)))

    @property
    def link(self) -> npt.NDArray[np.int64]:
        """Number of the link that each path belongs to, shape (paths,)."""
        return np.repeat(np.arange(len(self)), np.diff(self.path_offset))

    def to_pandas(self) -> Any:
        """Makes a table of one row a path.

        Returns
        -------
        pandas.DataFrame
            Columns ``link``, ``delay_s``, ``departure_azimuth_rad``, ``arrival_azimuth_rad``, ``gain_db``, and ``interactions`` like
            ``"R12 D7"``: "LoS" for a path without interactions that is as long as its link, "?" for any other path without interactions: those of such a path are not known.
        """
        import pandas as pd

        names = [f"{'RD?'[min(kind, 2)]}{i}" for kind, i in zip(self.interaction_kind, self.interaction_id)]
        straight = ["LoS" if is_one else "?" for is_one in self._held.is_straight()]
        ends = self.interaction_offset
        return pd.DataFrame(
            {
                "link": self.link,
                "delay_s": self.delay_s,
                "departure_azimuth_rad": self.departure_azimuth_rad,
                "arrival_azimuth_rad": self.arrival_azimuth_rad,
                "gain_db": self.gain_db,
                "interactions": [" ".join(names[a:b]) or alone for a, b, alone in zip(ends[:-1], ends[1:], straight)],
            }
        )


def _known(columns: dict[str, npt.ArrayLike]) -> None:
    """Refuses columns that paths do not have."""
    unknown = columns.keys() - COLUMNS
    if unknown:
        raise TypeError(f"Paths have no {', '.join(sorted(unknown))}")


COLUMNS = tuple(name for name, value in vars(Paths).items() if isinstance(value, Column))


def held(paths: Paths) -> _native.Paths:
    """Paths as the native module takes them."""
    if not isinstance(paths, Paths):
        raise TypeError(f"paths: expected Paths, got {type(paths).__name__}")
    return paths._held


class Tracer:
    """Finds all paths within limits between points of a scene.

    Parameters
    ----------
    scene : Scene
        The buildings.
    limits : {"converged", "r2d1"}
        Values of the limits that are not given: "converged", the default, those stated below; further reflections and weaker paths change
        labels by 1 dB in the mean. "r2d1" 2 reflections, 1 diffraction and a dynamic range of 60 dB, in less time.
    frequency_hz : float
        Carrier in Hz, 1 to 1e18; 3.5e9 by default.
    material : str or tuple of two floats
        Of the walls: "concrete" (after ITU-R P.2040-3), the default, "pec" for a perfect conductor, or a pair of relative permittivity
        and conductivity in S/m.
    max_reflections, max_diffractions : int
        Most of each on a path, 0 to 1000; 5 and 2 by default.
    max_interactions : int
        Most reflections and diffractions together on a path; the sum of both limits by default.
    slope_diffraction : bool
        Waves from corner to corner take their slope along; True by default.
    dynamic_range_db : float or None
        Paths are left out that are weaker than the link's strongest by more, in dB; 20 by default, None keeps all.
    max_fallback_diffractions : int
        A link without a path goes on with up to so many diffractions, at estimated levels, 0 to 1000; 0 by default: none does.
    max_images : int
        Most images of a terminal, of some 80 bytes each; 10,000,000 by default. A trace that needs more is refused.
    max_wave_bytes : int
        Most memory in bytes for the walls that corners see, and for the waves at corners, of a terminal and of all; 2**30 by default. What needs more is refused.

    Attributes
    ----------
    scene : Scene
    """

    def __init__(self, scene: _native.Scene, **limits: Unpack[Limits]) -> None:
        self.scene = scene
        self._tracer = _native.Tracer(scene, **limits)
        self._limits = limits

    def __repr__(self) -> str:
        return f"Tracer({', '.join([repr(self.scene), *(f'{name}={value!r}' for name, value in self._limits.items())])})"

    def trace(self, tx: npt.ArrayLike, rx: npt.ArrayLike) -> Paths:
        """Traces the links from each transmitter to each receiver.

        Parameters
        ----------
        tx : array_like, shape (2,) or (m, 2)
            Transmitters in m, outdoors.
        rx : array_like, shape (2,) or (n, 2)
            Receivers in m, outdoors.

        Returns
        -------
        Paths
            Of m * n links: first those of the first transmitter, in the order of the receivers.
        """
        return Paths._of(self._tracer.trace(tx, rx))

    def trace_pairs(self, tx: npt.ArrayLike, rx: npt.ArrayLike) -> Paths:
        """Traces the link of each pair of a transmitter and a receiver, such as the links of a measurement.

        Places that are in several pairs are prepared once; those of all pairs stay in memory until the call ends, some 10 kB a receiver
        and up to some MB a transmitter.

        Parameters
        ----------
        tx : array_like, shape (2,) or (n, 2)
            Transmitters in m, outdoors.
        rx : array_like, shape (2,) or (n, 2)
            Receivers in m, outdoors, one for each transmitter.

        Returns
        -------
        Paths
            Of n links.
        """
        return Paths._of(self._tracer.trace_pairs(tx, rx))
