"""Settings of a training: the ``config.json`` beside its weights, as ``cargo xtask train`` writes it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from map2aps import _native

StrPath: TypeAlias = str | os.PathLike[str]
Settings: TypeAlias = dict[str, Any]

# What may differ between two accounts of one training.
FREE = ("data", "device", "initial_weights")
# What images are of, which no data set tells.
OF_IMAGES = ("frame", "sigma_px", "image_size")


def facts_of(kind: str, data: StrPath) -> Settings:
    """Settings of a model that learns a data set, but for the size of its images."""
    name, preset = kind.split()
    facts: Settings = json.loads(_native.training_facts(data))
    return {"model": name, "preset": preset} | facts


def beside(file: StrPath, kind: str) -> Settings | None:
    """Settings beside a file of weights of a model; None where there are none.

    Raises ``ValueError`` for those of another model, and for a file that holds none.
    """
    path = Path(file).with_name("config.json")
    if not path.is_file():
        return None
    try:
        settings: Settings = json.loads(path.read_text(encoding="utf-8"))
        stored = f"{settings['model']} {settings['preset']}"
    except (KeyError, TypeError, ValueError) as error:
        told = f"it lacks {error}" if isinstance(error, KeyError) else error
        raise ValueError(f"{path}: no settings of a training: {told}; move the file or the weights elsewhere") from error
    if stored != kind:
        told, found = (", preset ".join(of.split()) for of in (stored, kind))
        raise ValueError(f"{path}: it is of a training of {told}, and the weights beside it are of {found}; move one of them elsewhere")
    return settings


def to_write(kind: str, known: Settings | None, data: StrPath | None, image_size: int | None, has_images: bool) -> Settings | None:
    """Settings to keep with weights: those of a data set if one is given, else those that are known; None where nothing tells any."""
    if image_size is not None:
        if not has_images:
            raise ValueError(f"image_size: {kind.split()[0]} takes no images")
        if isinstance(image_size, bool) or not isinstance(image_size, int | np.integer) or image_size < 1:
            raise ValueError(f"image_size: expected a number of pixels, got {type(image_size).__name__} {image_size!r}")
    known_of_images = {name: known[name] for name in OF_IMAGES if name in known} if known else {}
    settings = known if data is None else facts_of(kind, data) | known_of_images
    if settings is None:
        if image_size is None:
            return None
        raise ValueError("image_size: it is kept with what else the model learnt; give data= too")
    size = image_size or known_of_images.get("image_size")
    if size is None and has_images:
        raise ValueError("image_size: nothing tells it; give the rows and columns of the images that the model learnt, the size= of ApsDataset")
    return settings | {"image_size": int(size or 0)}


def check_place(file: StrPath, kind: str, settings: Settings | None) -> None:
    """Makes sure that settings may be written beside a file of weights, and that weights without any are not taken for others.

    Raises ``ValueError`` where other settings are there that may not be replaced.
    """
    path, stored = Path(file).with_name("config.json"), beside(file, kind)
    if stored is None:
        return
    if settings is None:
        raise ValueError(f"{path}: it would be taken for the settings of these weights; give data= and image_size=, or another folder")
    if any(stored.get(name) != settings.get(name) for name in (stored.keys() | settings.keys()) - set(FREE)):
        weights = (one.name for one in path.parent.iterdir() if one.suffix in (".safetensors", ".pt", ".pth"))
        others = sorted(name for name in weights if name != Path(file).name)
        if others:
            raise ValueError(f"{path}: it tells another training, whose weights {others[0]} lie there too; give another folder")


@contextmanager
def written(file: StrPath, settings: Settings) -> Iterator[None]:
    """Writes settings beside a file of weights that is written within: they appear whole and after it, or not at all if that fails."""
    path = Path(file).with_name("config.json")
    partial = path.with_name(f".config.json.{os.getpid()}")
    text = json.dumps(settings, indent=2) + "\n"
    try:
        partial.write_text(text, encoding="utf-8")
        yield
        os.replace(partial, path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
