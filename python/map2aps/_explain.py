"""Links to look at."""

from __future__ import annotations

import html
import os
from pathlib import Path
from typing import Any

import numpy as np

from . import _native
from ._arrays import USUAL_PROTOCOL, Array, Protocol, label_settings
from ._paths import Paths, held


class Html:
    """A page. Notebooks show it as the value of a cell.

    Parameters
    ----------
    text : str
        The page in HTML.

    Attributes
    ----------
    text : str
        The page in HTML, as ``str`` gives it too.
    """

    def __init__(self, text: str) -> None:
        self.text = text

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"Html({len(self.text)} characters; save(file) writes it)"

    def _repr_html_(self) -> str:
        # In a frame, so that neither the page's style nor the notebook's reaches the other.
        page = html.escape(self.text, quote=True)
        return f'<iframe srcdoc="{page}" width="100%" height="760" frameborder="0"></iframe>'

    def save(self, file: str | os.PathLike[str]) -> None:
        """Writes the page to a file, in UTF-8.

        Parameters
        ----------
        file : path-like
            The file; one that is there is replaced.
        """
        Path(file).write_text(self.text, encoding="utf-8")


def _check(scene: _native.Scene, paths: Paths) -> None:
    if not isinstance(scene, _native.Scene):
        raise TypeError(f"scene: expected Scene, got {type(scene).__name__}")
    if not held(paths).may_be_of(scene):
        raise ValueError("scene: its buildings are not those that the paths were traced in; give the scene of their Tracer")


def _one(paths: Paths, link: int) -> Paths:
    held(paths)
    one = paths[link]
    if not (np.isfinite(one.tx_m).all() and np.isfinite(one.rx_m).all()):
        raise ValueError(f"paths: it is not known where the ends of link {link} are; give them by replace(tx_m=..., rx_m=...)")
    if len(one.gain) and not one.gain.any():
        raise ValueError(f"paths: link {link} receives no power: the gain of all its paths is 0")
    return one


def explain(
    scene: _native.Scene,
    paths: Paths,
    link: int = 0,
    protocol: Protocol = USUAL_PROTOCOL,
    array: Array | None = None,
    title: str | None = None,
) -> Html:
    """Tells which path makes which lobe of a link's spectrum.

    Parameters
    ----------
    scene : Scene
        The scene that the paths were traced in; another with the same walls is as good.
    paths : Paths
        Paths of one link or more.
    link : int
        The link among them.
    protocol : {"paper", "released"}
        Definition of the spectrum.
    array : UniformLinear or UniformCircular, optional
        The receiving array; 16 elements half a wavelength apart by default.
    title : str, optional
        Title of the page; the ends of the link by default.

    Returns
    -------
    Html
        The link on its map, its spectrum, and tables of lobes and paths.

    Raises
    ------
    ValueError
        For a scene of other buildings than those that the paths were traced in, and a link that has no path or unknown ends.
    """
    _check(scene, paths)
    one = _one(paths, link)
    if title is None:
        (x0, y0), (x1, y1) = one.tx_m[0], one.rx_m[0]
        title = f"From ({x0:g}, {y0:g}) m to ({x1:g}, {y1:g}) m"
    settings = label_settings(protocol, array, None)
    return Html(_native.explain(scene, held(one), settings, title))


def plot_link(paths: Paths, link: int = 0, scene: _native.Scene | None = None, ax: Any = None) -> Any:
    """Draws the paths of a link, strong ones on top and dark, with matplotlib.

    Parameters
    ----------
    paths : Paths
        Paths of one link or more.
    link : int
        The link among them.
    scene : Scene, optional
        Buildings to draw: those that the paths were traced in.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; new ones by default.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn in.
    """
    if scene is not None:
        _check(scene, paths)
    one = _one(paths, link)
    import matplotlib.pyplot as plt

    if ax is None:
        _, ax = plt.subplots()
    if scene is not None:
        for wall in scene.walls:
            ax.plot(*wall.T, color="0.5", linewidth=1.0)
    gain_db = one.gain_db
    for path in np.argsort(gain_db):
        first, last = one.interaction_offset[path : path + 2]
        line = np.concatenate([one.tx_m, one.interaction_point_m[first:last], one.rx_m])
        shade = np.clip((gain_db[path] - gain_db.max()) / 40.0 + 1.0, 0.1, 1.0)
        ax.plot(*line.T, color="tab:red", alpha=float(shade), linewidth=1.0)
    ax.plot(*one.tx_m.T, "k^", label="transmitter")
    ax.plot(*one.rx_m.T, "ko", label="receiver")
    ax.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    return ax
