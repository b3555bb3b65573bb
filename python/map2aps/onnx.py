"""Models in ONNX Runtime (PyPI: ``onnxruntime``), without PyTorch: files that ``cargo xtask export-onnx`` writes.

>>> from map2aps.onnx import OnnxModel
>>> model = OnnxModel("polar_reg.onnx")  # doctest: +SKIP
>>> power = model.predict(map2aps.PolarView(scene).input(tx, rx), domain="linear")  # doctest: +SKIP
"""

from __future__ import annotations

import json
import os
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
    providers : list of str, optional
        Execution providers of ONNX Runtime in order of preference; "CPUExecutionProvider" by default.

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
        For a file of ONNX that another program wrote.
    """

    def __init__(self, file: str | os.PathLike[str], providers: list[str] | None = None) -> None:
        import onnxruntime

        self._session: Any = onnxruntime.InferenceSession(os.fspath(file), providers=providers or ["CPUExecutionProvider"])
        facts = dict(self._session.get_modelmeta().custom_metadata_map)
        if not {"model", "preset"} <= facts.keys():
            raise ValueError(f"{os.fspath(file)}: its metadata name no model; was it written by 'cargo xtask export-onnx'?")
        self.name: str = facts.pop("model")
        self.preset: str = facts.pop("preset")
        size = facts.pop("image_size", None)
        self.image_size: int | None = None if size is None else int(size)
        self.settings: dict[str, Any] = {
            name: text if name in ("protocol", "frame") else json.loads(text) for name, text in facts.items()
        }

    def predict(
        self, conditions: npt.ArrayLike, domain: Literal["normalised", "linear"] = "normalised"
    ) -> npt.NDArray[np.float32]:
        """Predicts spectra.

        Parameters
        ----------
        conditions : array_like, shape (n, 3, image_size, image_size) or (n, 180, 214)
            Condition images, or the input of Polar-Reg, as `map2aps.torch.ApsDataset` and `map2aps.PolarView` make them.
        domain : {"normalised", "linear"}
            Spectra as the model learnt them, or power relative to the link's maximum, which for labels of the protocol "paper" is the
            same for models of any training.

        Returns
        -------
        ndarray of float32, shape (n, 180)

        Raises
        ------
        ValueError
            For conditions of another shape, numbers that are not finite, and power of a model that does not tell its statistics.
        """
        if domain not in ("normalised", "linear"):
            raise ValueError(f"domain: '{domain}' is neither 'normalised' nor 'linear'")
        (takes,) = self._session.get_inputs()
        # Numbers beyond single precision are found below.
        with np.errstate(over="ignore"):
            given = np.asarray(conditions, dtype=np.float32)
        shape = tuple(takes.shape[1:])
        if given.ndim != len(shape) + 1 or given.shape[1:] != shape:
            wanted = ", ".join(map(str, ("n", *shape)))
            raise ValueError(f"conditions: expected shape ({wanted}), got {given.shape}")
        if not np.isfinite(given).all():
            raise ValueError("conditions: a number is not finite")
        spectra: npt.NDArray[np.float32]
        (spectra,) = self._session.run(None, {takes.name: given})
        if domain == "normalised":
            return spectra
        statistics = self.settings.get("training_statistics")
        if statistics is None:
            raise ValueError("domain: the file does not tell the statistics that normalise its spectra; export weights beside their config.json")
        return (spectra * np.float64(statistics["std"]) + np.float64(statistics["mean"])).astype(np.float32)
