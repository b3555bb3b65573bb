"""Models in ONNX Runtime (PyPI: ``onnxruntime``), without PyTorch: files that ``cargo xtask export-onnx`` writes.

>>> from map2aps.onnx import OnnxModel
>>> model = OnnxModel("polar_reg.onnx")  # doctest: +SKIP
>>> power = model.predict(map2aps.PolarView(scene).ways(tx, rx), domain="linear")  # doctest: +SKIP
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

__all__ = ["OnnxModel"]


class OnnxModel:
    """An exported model, ready to predict.

    Parameters
    ----------
    file : path-like
        File of ``cargo xtask export-onnx``.
    providers : sequence of str
        Execution providers of ONNX Runtime in order of preference.

    Attributes
    ----------
    name, preset : str
        The model and its sizes, as of `map2aps.torch.models.build`.
    image_size : int or None
        Rows and columns of its condition images; None for a model that takes none.
    settings : dict
        What the weights were trained on: ``protocol``, ``training_statistics`` (``mean``, ``std``) and ``label``, of images also ``sigma_px``
        and ``frame``. Empty for weights that had no ``config.json`` beside them.

    Raises
    ------
    ValueError
        For a file that ONNX Runtime does not read or another program wrote, and a provider that it does not have.

    Warns
    -----
    UserWarning
        For a model of images drawn about the receiver (``--frame receiver``), which this package does not draw.
    """

    def __init__(self, file: str | os.PathLike[str], providers: Sequence[str] = ("CPUExecutionProvider",)) -> None:
        import onnxruntime

        name = os.fsdecode(file)
        available = onnxruntime.get_available_providers()
        missing = [providers] if isinstance(providers, str) else [one for one in providers if one not in available]
        if missing:
            raise ValueError(f"providers: expected a list of names out of {', '.join(available)}, got {missing[0]!r}")
        # A file that is not there is told as every other.
        with open(name, "rb"):
            pass
        try:
            self._session: Any = onnxruntime.InferenceSession(name, providers=list(providers))
            facts = dict(self._session.get_modelmeta().custom_metadata_map)
            self.name: str = facts["model"]
            self.preset: str = facts["preset"]
            size = facts.get("image_size")
            self.image_size: int | None = None if size is None else int(size)
            # Numbers of rays and kinds of ways that the last two numbers of a way are below.
            self._counts = [int(facts[fact]) for fact in ("directions", "kinds") if fact in facts]
            self.settings: dict[str, Any] = {fact: facts[fact] for fact in ("protocol", "frame") if fact in facts}
            self.settings.update({fact: json.loads(facts[fact]) for fact in ("sigma_px", "training_statistics", "label") if fact in facts})
        except Exception as error:
            told = f"it lacks {error}" if isinstance(error, KeyError) else str(error)
            raise ValueError(f"{name}: no model of 'cargo xtask export-onnx': {told}") from error
        if self.settings.get("frame", "map") != "map":
            warnings.warn(f"{name}: it takes images about the receiver, and ApsDataset draws those of the map", stacklevel=2)

    def __repr__(self) -> str:
        return f"OnnxModel({self.name}, {self.preset})"

    def predict(
        self, conditions: npt.ArrayLike, domain: Literal["normalised", "linear"] = "normalised"
    ) -> npt.NDArray[np.float32]:
        """Predicts spectra.

        Parameters
        ----------
        conditions : array_like, shape (n, 3, image_size, image_size) or (n, ways, 16)
            Condition images, or the input of Polar-Reg, as `map2aps.torch.ApsDataset` and `map2aps.PolarView` make them.
        domain : {"normalised", "linear"}
            Spectra as the model learnt them, or power relative to the link's maximum, of a model of the protocol "paper" alone: labels
            of "released" are normalised by their own deviation as well.

        Returns
        -------
        ndarray of float32, shape (n, 180)

        Raises
        ------
        ValueError
            For conditions of another shape or type, numbers that are not finite, ways of no ray or kind, and power of a model that does not tell how.
        """
        if domain not in ("normalised", "linear"):
            raise ValueError(f"domain: '{domain}' is neither 'normalised' nor 'linear'")
        statistics = self.settings.get("training_statistics", {})
        if domain == "linear" and not (self.settings.get("protocol") == "paper" and {"mean", "std"} <= statistics.keys()):
            raise ValueError(
                "domain: only spectra that were normalised as by the protocol 'paper', with statistics that the file tells, are taken back to "
                f"power; this model's protocol is {self.settings.get('protocol')!r}: export weights beside their config.json"
            )
        (takes,) = self._session.get_inputs()
        try:
            array = np.asarray(conditions)
        except (RuntimeError, TypeError, ValueError) as error:
            raise ValueError(f"conditions: expected numbers, got {type(conditions).__name__}: {error}") from error
        shape = tuple(takes.shape)
        # Names stand for dimensions of any length; of ways there is one at least, of zeros where there is none.
        fits = array.ndim == len(shape) and all(isinstance(n, str) or n == found for n, found in zip(shape, array.shape))
        if array.dtype.kind not in "fiu" or not fits or 0 in array.shape[1:]:
            wanted = ", ".join(map(str, ("n", *shape[1:])))
            raise ValueError(f"conditions: expected numbers of shape ({wanted}), got {array.dtype} of shape {array.shape}")
        # Numbers beyond single precision are found below.
        with np.errstate(over="ignore"):
            given = array.astype(np.float32, copy=False)
        if not np.isfinite(given).all():
            raise ValueError("conditions: a number is not finite")
        if self._counts:
            numbers = given[..., -2:]
            if (numbers < 0).any() or (numbers >= self._counts).any() or (numbers % 1 != 0).any():
                raise ValueError(f"conditions: rays and kinds of ways are whole numbers from 0 to below {self._counts[0]} and {self._counts[1]}")
        spectra: npt.NDArray[np.float32]
        (spectra,) = self._session.run(None, {takes.name: given})
        if not np.isfinite(spectra).all():
            raise ValueError("conditions: the model gives numbers for them that are not finite")
        if domain == "normalised":
            return spectra
        std, mean = (np.float64(statistics[of]) for of in ("std", "mean"))
        return (spectra * std + mean).astype(np.float32)
