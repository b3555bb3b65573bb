"""Data sets on disk."""

from __future__ import annotations

import json
import os
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import USUAL_PROTOCOL, Array, Protocol, label_settings
from ._paths import Limits

if TYPE_CHECKING:
    from typing_extensions import Unpack

Progress: TypeAlias = Callable[[int, int], object]
StrPath: TypeAlias = str | os.PathLike[str]


# By the beginning of an array's name what makes a data set store it, if that is not always stored.
STORED_BY = {"pdp_": "store_pdp=True", "path_": "store_paths=True", "interaction_": "store_paths=True"}


class Map:
    """One map of a data set; its arrays are mapped into memory, and read where they are looked at.

    Attributes
    ----------
    id : int
        Number of the map in the data set.
    links : int
        Number of links, with or without a label.
    """

    def __init__(self, folder: Path, entry: dict[str, Any]) -> None:
        self._folder, self._entry = folder, entry
        self.id = int(entry["id"])
        self.links = int(entry["links"])
        self._files = {Path(file["name"]).stem: file for file in entry["files"]}

    def __repr__(self) -> str:
        return f"Map({self.id}, {self.links} links)"

    def keys(self) -> list[str]:
        """Tells which arrays the map has.

        Returns
        -------
        list of str
            Their names, as the page on the format of data sets lists them.
        """
        return list(self._files)

    def __iter__(self) -> Iterator[str]:
        """The names."""
        return iter(self._files)

    def __contains__(self, name: object) -> bool:
        """Tells if the map has an array of this name.

        Parameters
        ----------
        name : object
            The name.

        Returns
        -------
        bool
        """
        return name in self._files

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """Opens an array.

        Parameters
        ----------
        name : str
            Its name: ``tx`` and ``rx`` (places in m), ``link_tx`` and ``link_rx`` (rows of these), ``status``, ``aps_db``, or another
            of `keys`.

        Returns
        -------
        ndarray
            Read-only, of the shape and type that the page on the format of data sets states.

        Raises
        ------
        KeyError
            For an array that the data set does not store.
        ValueError
            For a file of another shape than the manifest says.
        """
        file = self._files.get(name)
        if file is None:
            options = [option for begin, option in STORED_BY.items() if str(name).startswith(begin)]
            remedy = f"; make_dataset(..., {options[0]}) stores it" if options else ""
            raise KeyError(f"map {self.id} has no array {name!r}, only {', '.join(self._files)}{remedy}")
        path = self._folder / file["name"]
        if 0 in file["shape"]:
            array: npt.NDArray[Any] = np.load(path)
        else:
            array = np.load(path, mmap_mode="r")
        if list(array.shape) != file["shape"]:
            raise ValueError(f"{path}: its shape is {array.shape}, the manifest says {tuple(file['shape'])}")
        return array

    @property
    def is_valid(self) -> npt.NDArray[np.bool_]:
        """True for links with a label, shape (links,)."""
        return np.asarray(self["status"] == 0)


class Dataset:
    """A finished data set. Opening it reads the manifest alone; ``len`` and a loop go over its maps.

    Parameters
    ----------
    path : path-like
        Folder of the data set.

    Attributes
    ----------
    path : pathlib.Path
        Folder of the data set.
    manifest : dict
        The manifest, checked.
    """

    def __init__(self, path: StrPath) -> None:
        self.path = Path(path)
        self.manifest: dict[str, Any] = json.loads(_native.manifest(self.path))

    def __repr__(self) -> str:
        return f"Dataset('{self.path}', {len(self)} maps, {self.links} links)"

    def __reduce__(self) -> tuple[type[Dataset], tuple[Path]]:
        return type(self), (self.path,)

    @cached_property
    def _entries(self) -> dict[int, dict[str, Any]]:
        return {entry["id"]: entry for entry in self.manifest["maps"]}

    @property
    def links(self) -> int:
        """Number of links, with or without a label."""
        return sum(int(entry["links"]) for entry in self.manifest["maps"])

    @property
    def missing_links(self) -> int:
        """Number of links wanted of transmitters that reach too few points; 0 where the data set does not tell it."""
        return sum(int(of.get("missing_links", 0)) for of in self._statistics)

    @property
    def _statistics(self) -> list[dict[str, Any]]:
        """Statistics of the maps that have any."""
        return [entry["statistics"] for entry in self.manifest["maps"] if entry.get("statistics")]

    @property
    def protocol(self) -> Protocol | None:
        """Definition of the labels, "paper" or "released"; None where the data set does not tell it."""
        found: Protocol | None = self.manifest["configuration"].get("label", {}).get("protocol")
        return found

    @property
    def angle_deg(self) -> npt.NDArray[np.float64]:
        """Azimuth of each bin of the spectra in degrees, shape (bins,)."""
        axis = self.manifest["layout"]["aps"]["axis"]
        return np.linspace(axis["start"], axis["stop"], axis["count"], endpoint=axis["endpoint"])

    def __len__(self) -> int:
        """Number of maps."""
        return len(self._entries)

    def __iter__(self) -> Iterator[Map]:
        """The maps, by ascending id."""
        return (self[i] for i in self._entries)

    def __contains__(self, of: object) -> bool:
        """Tells if the data set has a map.

        Parameters
        ----------
        of : object
            Its id, or the map as a loop gives it.

        Returns
        -------
        bool
        """
        return (of.id if isinstance(of, Map) else of) in self._entries

    def __getitem__(self, map_id: int) -> Map:
        """Opens a map.

        Parameters
        ----------
        map_id : int
            Its id, which is not its place among the maps.

        Returns
        -------
        Map

        Raises
        ------
        KeyError
            For an id that no map has.
        """
        entry = self._entries.get(map_id)
        if entry is None:
            raise KeyError(f"the data set has no map {map_id!r}, only {', '.join(map(str, self._entries))}")
        return Map(self.path / f"map_{map_id:04}", entry)

    def split(self, part: Literal["train", "develop", "test"]) -> list[int]:
        """Tells which maps are in a part of the split.

        Parameters
        ----------
        part : {"train", "develop", "test"}
            The part.

        Returns
        -------
        list of int
            Ids of the maps; none for a part without maps.
        """
        if part not in ("train", "develop", "test"):
            raise ValueError(f"part: '{part}' is none of 'train', 'develop' and 'test'")
        return list(self.manifest["split"][part])


def _bar(progress: Progress | bool | None) -> tuple[Progress | None, Callable[[], object]]:
    """The function that is told of progress, and the one that ends it."""
    if callable(progress):
        return progress, lambda: None
    if not (progress is None or isinstance(progress, bool)):
        raise TypeError(f"progress: expected a function, True, False or None, got {type(progress).__name__} {progress!r}")
    if not progress:
        return None, lambda: None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None, lambda: None
    bar = tqdm(unit="link", unit_scale=True)

    def show(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)

    return show, bar.close


def make_dataset(
    path: StrPath,
    maps: int | StrPath = 10,
    *,
    tx_per_map: int = 20,
    rx_per_map: int = 100,
    receivers: Literal["reached", "outdoor"] = "reached",
    orientations: int = 1,
    map_ids: npt.ArrayLike | None = None,
    seed: int = 42,
    protocol: Protocol = USUAL_PROTOCOL,
    array: Array | None = None,
    sampling_rate_hz: float | None = None,
    store_pdp: bool = False,
    store_paths: bool = False,
    tile_m: float | None = None,
    metric: bool = False,
    all_polygons: bool = False,
    progress: Progress | bool | None = True,
    **limits: Unpack[Limits],
) -> Dataset:
    """Makes a data set in a folder, or goes on with one that was interrupted. The same settings make the same bytes.

    Parameters
    ----------
    path : path-like
        Folder of the data set.
    maps : int or path-like
        Number of synthetic cities, a folder of RadioMapSeer files, or the GeoJSON file of a city.
    tx_per_map, rx_per_map : int
        Transmitters of a map, and receivers of each.
    receivers : {"reached", "outdoor"}
        Points that the transmitter reaches within the limits, or the same points for all transmitters of a map.
    orientations : int
        Orientations of each training map, 1 to 8: quarter turns, and their mirror images.
    map_ids : array_like of int, shape (n,), optional
        Ids of the maps to take; all by default.
    seed : int
        Seed of terminals, synthetic cities and split.
    protocol, array, sampling_rate_hz
        Settings of the labels; see `label`.
    store_pdp, store_paths : bool
        Store power delay profiles, and paths, from which labels can be made anew.
    tile_m : float, optional
        Side of the maps that a city is cut into, in m; 256 by default.
    metric : bool
        The coordinates of the city are metres, not degrees.
    all_polygons : bool
        Every polygon of the city is a building, whether or not it has a building tag.
    progress : callable, bool or None
        Called with the number of links done and that of all, some times a second; True shows a bar where tqdm is installed.
    **limits
        Settings of the trace; see `Tracer`.

    Returns
    -------
    Dataset
        The finished data set.

    Warns
    -----
    UserWarning
        For features of a city that became no building, before anything is made, and where more than a tenth of the links is missing
        since their transmitters reach too few points; `Dataset.missing_links` tells any.
    """
    settings = {
        "maps": maps,
        "map_ids": map_ids,
        "tile_m": tile_m,
        "metric": metric,
        "all_polygons": all_polygons,
        "tx_per_map": tx_per_map,
        "rx_per_map": rx_per_map,
        "receivers": receivers,
        "orientations": orientations,
        "seed": seed,
        "store_pdp": store_pdp,
        "store_paths": store_paths,
    }
    tell, close = _bar(progress)
    try:
        _native.make_dataset(path, settings, label_settings(protocol, array, sampling_rate_hz), tell, **limits)
    finally:
        close()
    made = Dataset(path)
    told = _many_missing(made)
    if told:
        warnings.warn(f"{os.fspath(path)}: {told}", stacklevel=2)
    return made


def relabel(
    data: Dataset | StrPath,
    path: StrPath,
    *,
    protocol: Protocol | None = None,
    array: Array | None = None,
    sampling_rate_hz: float | None = None,
    store_pdp: bool | None = None,
    store_paths: bool | None = None,
    progress: Progress | bool | None = True,
) -> Dataset:
    """Labels the stored paths of a data set anew: another protocol, array or bandwidth, without a trace.

    Parameters
    ----------
    data : Dataset or path-like
        A finished data set that stores paths (``store_paths=True``).
    path : path-like
        Folder of the new data set; one that was interrupted is continued.
    protocol : {"paper", "released"}, optional
        Definition of the labels; that of `data` by default.
    array, sampling_rate_hz
        See `label`; those of `data` by default.
    store_pdp, store_paths : bool, optional
        Store power delay profiles, and the paths again; as `data` does by default.
    progress : callable, bool or None
        See `make_dataset`.

    Returns
    -------
    Dataset
        The new data set.
    """
    source = data if isinstance(data, Dataset) else Dataset(data)
    chosen = source.protocol if protocol is None else protocol
    if chosen is None:
        raise ValueError("protocol: the data set tells none of its own; name one")
    settings = label_settings(chosen, array, sampling_rate_hz)
    tell, close = _bar(progress)
    try:
        _native.relabel(source.path, path, settings, store_pdp, store_paths, tell)
    finally:
        close()
    return Dataset(path)


def _many_missing(dataset: Dataset) -> str:
    """Links that were asked for and are not there, and why; empty where they are no more than a tenth."""
    asked_for = dataset.links + dataset.missing_links
    if 10 * dataset.missing_links <= asked_for:
        return ""
    reasons = Counter[str]()
    for of in dataset._statistics:
        reasons.update(of.get("points_not_reached", {}))
    why = ", ".join(f"{count} {reason}" for reason, count in sorted(reasons.items()))
    return (
        f"{dataset.links} links of the {asked_for} asked for: some transmitters reach too few points "
        f"(not reached: {why}); receivers='outdoor' keeps links without a path"
    )
