"""`map2aps.onnx`: exported models, opened and asked."""

import json
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch

import map2aps
from docstrings import gaps
from map2aps.onnx import OnnxModel
from map2aps.torch import models
from pages import ROOT


def export(*words: object) -> None:
    command = ["cargo", "run", "--quiet", "--package", "xtask-models", "--", "export-onnx", *map(str, words)]
    subprocess.run(command, cwd=ROOT, check=True)


@pytest.fixture(scope="module")
def polar(tmp_path_factory: pytest.TempPathFactory) -> OnnxModel:
    file = tmp_path_factory.mktemp("onnx") / "polar_reg.onnx"
    export("--model", "polar_reg", "--out", file)
    return OnnxModel(file)


def test_shipped_weights_predict_what_they_do_in_pytorch(polar: OnnxModel, scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    assert (polar.name, polar.preset, polar.image_size) == ("polar_reg", "small", None)
    own = models.shipped("polar_reg")
    assert polar.settings["protocol"] == "paper" and polar.settings["training_statistics"] == own.settings["training_statistics"]
    ways = map2aps.PolarView(scene).ways(outdoors[0], outdoors[10:20])
    with torch.no_grad():
        expected = own(torch.from_numpy(np.asarray(ways))).numpy()
    assert np.abs(polar.predict(ways) - expected).max() < 1e-4
    power = polar.predict(ways, domain="linear")
    statistics = own.settings["training_statistics"]
    assert power.dtype == np.float32 and np.allclose(power, expected * statistics["std"] + statistics["mean"], atol=1e-4)
    # Spectra of this model reach 1 and never lie below nothing.
    assert np.allclose(power.max(axis=1), 1.0, atol=1e-3) and power.min() > -1e-3
    assert polar.predict(ways[:0]).shape == (0, 180)
    assert np.array_equal(polar.predict(np.asarray(ways, np.float64)[::-1])[::-1], polar.predict(ways))


def test_bad_conditions_are_told(polar: OnnxModel) -> None:
    good = np.zeros((2, 30, 16), np.float32)
    for conditions, domain, told in [
        (good[0], "linear", r"shape \(n, ways, 16\), got float32 of shape \(30, 16\)"),
        (good[:, :0], "linear", r"got float32 of shape \(2, 0, 16\)"),
        (np.zeros((1, 3, 64, 64)), "linear", r"got float64 of shape \(1, 3, 64, 64\)"),
        (np.full_like(good, np.nan), "linear", "not finite"),
        (good - 1, "linear", "below 720 and 15"),
        (good + 15, "linear", "below 720 and 15"),
        (good + 0.5, "linear", "whole numbers"),
        (np.full(good.shape, 1e300), "linear", "not finite"),
        (good, "db", "'db' is neither"),
        ([["a"]], "linear", r"got <U1 of shape \(1, 1\)"),
        (good > 0, "linear", "got bool of shape"),
        (good.astype(complex), "linear", "got complex64 of shape|got complex128 of shape"),
        ([good[0], good[0, :2]], "linear", "got list"),
        (torch.zeros(2, 30, 16, requires_grad=True), "linear", "got Tensor"),
    ]:
        with pytest.raises(ValueError, match=told):
            polar.predict(conditions, domain=domain)


def test_weights_without_their_settings_predict_normalised_spectra_alone(tmp_path: Path) -> None:
    weights, file = tmp_path / "weights.safetensors", tmp_path / "model.onnx"
    torch.manual_seed(1)
    model = models.build("ms_mlp", "small").eval()
    models.save(model, weights)
    export("--weights", weights, "--out", file, "--image-size", 48)
    exported = OnnxModel(file)
    assert (exported.name, exported.image_size, exported.settings) == ("ms_mlp", 48, {})
    images = np.random.default_rng(1).random((3, 3, 48, 48))
    with torch.no_grad():
        assert np.abs(exported.predict(images) - model(torch.from_numpy(images).float()).numpy()).max() < 1e-4
    with pytest.raises(ValueError, match="config.json"):
        exported.predict(images, domain="linear")


def test_models_that_predict_something_else_say_so(tmp_path: Path) -> None:
    file, weights = tmp_path / "model.onnx", tmp_path / "weights.safetensors"
    models.save(models.build("ms_mlp", "small"), weights)
    export("--weights", weights, "--out", file, "--image-size", 32)
    model = onnx.load(file)

    def told(**facts: str) -> Path:
        changed = tmp_path / f"{'-'.join(facts)}.onnx"
        known = {one.key: one.value for one in model.metadata_props}
        onnx.helper.set_model_props(model, {**known, **facts})
        onnx.save(model, changed)
        onnx.helper.set_model_props(model, known)
        return changed

    images = np.zeros((1, 3, 32, 32))
    statistics = json.dumps({"mean": 0.1, "std": 0.3})
    with pytest.raises(ValueError, match="protocol is 'released'"):
        OnnxModel(told(protocol="released", training_statistics=statistics)).predict(images, domain="linear")
    with pytest.raises(ValueError, match="statistics that the file tells"):
        OnnxModel(told(protocol="paper", training_statistics="{}")).predict(images, domain="linear")
    assert OnnxModel(told(author="somebody")).predict(images).shape == (1, 180)
    with pytest.warns(UserWarning, match="images about the receiver"):
        OnnxModel(told(frame="receiver"))
    for name, text in (("image_size", "abc"), ("label", "{")):
        with pytest.raises(ValueError, match="no model of 'cargo xtask export-onnx'"):
            OnnxModel(told(**{name: text}))


def test_one_model_answers_threads(polar: OnnxModel) -> None:
    ways = np.random.default_rng(1).random((4, 30, 16), dtype=np.float32)
    ways[..., 14:] = np.floor(ways[..., 14:] * (720, 15))
    expected = polar.predict(ways)
    with ThreadPoolExecutor(4) as threads:
        assert all(np.array_equal(found, expected) for found in threads.map(lambda _: polar.predict(ways), range(8)))


def test_files_of_others_are_refused(polar: OnnxModel, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nothing.onnx"):
        OnnxModel(tmp_path / "nothing.onnx")
    (tmp_path / "junk.onnx").write_bytes(b"junk")
    with pytest.raises(ValueError, match="junk.onnx: no model"):
        OnnxModel(os.fsencode(tmp_path / "junk.onnx"))
    for providers in ("CPUExecutionProvider", ["NoSuchProvider"]):
        with pytest.raises(ValueError, match="providers: .*CPUExecutionProvider"):
            OnnxModel(tmp_path / "junk.onnx", providers=providers)
    value = onnx.helper.make_tensor_value_info("x", onnx.TensorProto.FLOAT, [1])
    node = onnx.helper.make_node("Identity", ["x"], ["y"])
    graph = onnx.helper.make_graph([node], "g", [value], [onnx.helper.make_tensor_value_info("y", onnx.TensorProto.FLOAT, [1])])
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 17)], ir_version=8)
    onnx.save(model, tmp_path / "foreign.onnx")
    with pytest.raises(ValueError, match="foreign.onnx: no model .* it lacks 'model'"):
        OnnxModel(tmp_path / "foreign.onnx")
    assert json.loads(json.dumps(polar.settings)) == polar.settings


def test_the_module_tells_what_it_takes_and_gives() -> None:
    assert gaps(map2aps.onnx) == []
