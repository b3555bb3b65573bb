"""The native module; `map2aps` documents what it offers."""

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "Examples",
    "Paths",
    "PolarView",
    "Scene",
    "Tracer",
    "__version__",
    "array_response",
    "explain",
    "label",
    "label_differences",
    "make_dataset",
    "manifest",
    "metrics",
    "relabel",
    "shipped",
    "training_facts",
]

__version__: str

@final
class Scene:
    """Buildings of a city, checked, repaired and united; make one by a method ``from_...`` or `synthetic`."""

    @staticmethod
    def from_radiomapseer(file: str | os.PathLike[str], *, close_gaps_m: float | None = None) -> Scene: ...
    @staticmethod
    def from_geojson(
        file: str | os.PathLike[str],
        *,
        tile: int | None = None,
        tile_m: float | None = None,
        metric: bool = False,
        all_polygons: bool = False,
        close_gaps_m: float | None = None,
    ) -> Scene: ...
    @staticmethod
    def synthetic(seed: int = 1, *, close_gaps_m: float | None = None) -> Scene: ...
    @staticmethod
    def from_polygons(
        polygons: Sequence[npt.ArrayLike],
        *,
        area: tuple[float, float, float, float] | None = None,
        close_gaps_m: float | None = None,
    ) -> Scene: ...
    def is_outdoor(self, points_m: npt.ArrayLike) -> npt.NDArray[np.bool_]: ...
    def raster(self, size: int = 256) -> npt.NDArray[np.uint8]: ...
    @property
    def outlines(self) -> list[npt.NDArray[np.float64]]: ...
    @property
    def walls(self) -> npt.NDArray[np.float64]: ...
    @property
    def area(self) -> list[float] | None: ...
    @property
    def repairs(self) -> str: ...

@final
class Tracer:
    def __new__(cls, scene: Scene, **limits: Any) -> Tracer: ...
    def trace(self, tx: npt.ArrayLike, rx: npt.ArrayLike) -> Paths: ...
    def trace_pairs(self, tx: npt.ArrayLike, rx: npt.ArrayLike) -> Paths: ...

@final
class Paths:
    def __new__(cls, columns: Mapping[str, npt.ArrayLike], digest: str | None = None) -> Paths: ...
    def __len__(self) -> int: ...
    @property
    def count(self) -> int: ...
    def column(self, name: str) -> npt.NDArray[Any]: ...
    def is_straight(self) -> list[bool]: ...
    def take(self, links: Sequence[int]) -> Paths: ...
    @property
    def digest(self) -> str | None: ...
    def may_be_of(self, scene: Scene) -> bool: ...

@final
class PolarView:
    def __new__(cls, scene: Scene) -> PolarView: ...
    def ways(self, tx: npt.ArrayLike, rx: npt.ArrayLike) -> npt.NDArray[np.float32]: ...

def label(paths: Paths, settings: dict[str, Any], pdp: bool) -> dict[str, npt.NDArray[Any]]: ...
def make_dataset(
    out: str | os.PathLike[str],
    settings: dict[str, Any],
    label: dict[str, Any],
    progress: Callable[[int, int], object] | None,
    **limits: Any,
) -> None: ...
def relabel(
    folder: str | os.PathLike[str],
    out: str | os.PathLike[str],
    label: dict[str, Any],
    store_pdp: bool | None,
    store_paths: bool | None,
    progress: Callable[[int, int], object] | None,
) -> None: ...
def manifest(folder: str | os.PathLike[str]) -> str: ...
def metrics(
    truth: npt.ArrayLike,
    prediction: npt.ArrayLike,
    protocol_name: str,
    map_ids: npt.ArrayLike | None = None,
    data_range: float | None = None,
) -> dict[str, Any]: ...
def explain(
    scene: Scene, paths: Paths, settings: dict[str, Any], title: str
) -> str: ...

@final
class Examples:
    def __new__(
        cls, folder: str | os.PathLike[str], split: str, settings: dict[str, Any]
    ) -> Examples: ...
    def __len__(self) -> int: ...
    def batch(self, indices: npt.ArrayLike) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]: ...
    @property
    def links(self) -> npt.NDArray[np.int64]: ...
def label_differences(protocol: str, learnt: str, found: str) -> list[tuple[bool, str]]: ...
def shipped(name: str) -> tuple[bytes, str]: ...
def training_facts(folder: str | os.PathLike[str]) -> str: ...
def array_response(folder: str | os.PathLike[str]) -> npt.NDArray[np.float64]: ...
