"""Exported models in ONNX Runtime."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from safetensors.numpy import load_file

from map2aps.torch import ApsDataset, models
from pages import ROOT, blocks

GOLDEN = ROOT / "tests" / "golden"


def script(name: str) -> ModuleType:
    """A script that made golden values: its weights and inputs."""
    spec = importlib.util.spec_from_file_location(name, GOLDEN / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # The script of Polar-Reg imports that of the others.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def golden() -> ModuleType:
    return script("models")


@pytest.fixture(scope="module")
def polar(golden: ModuleType) -> ModuleType:
    return script("polar_reg")


def run(*args: object) -> None:
    command = ["cargo", "run", "--quiet", "--package", "xtask-models", "--", *map(str, args)]
    subprocess.run(command, cwd=ROOT, check=True)


def exported(model: torch.nn.Module, folder: Path, *options: object) -> onnxruntime.InferenceSession:
    weights, file = folder / "weights.safetensors", folder / "model.onnx"
    models.save(model.float(), weights)
    run("export-onnx", "--weights", weights, "--out", file, *options)
    onnx.checker.check_model(str(file), full_check=True)
    return onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])


def worst(session: onnxruntime.InferenceSession, links: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference to the spectra of two links, predicted one by one and as a batch of five."""
    (name,) = (value.name for value in session.get_inputs())
    errors = []
    for batch in ([0], [1], [0, 1, 1, 0, 1]):
        (found,) = session.run(None, {name: links[batch].astype(np.float32)})
        assert found.shape == (len(batch), 180) and found.dtype == np.float32
        errors.append(np.abs(found - expected[batch]).max())
    return float(max(errors))


@pytest.mark.parametrize("name", [name for name in models.MODELS if name != "polar_reg"])
def test_onnx_runtime_computes_the_golden_values_of_a_model_of_images(name: str, golden: ModuleType, tmp_path: Path) -> None:
    session = exported(golden.set_weights(models.build(name)), tmp_path, "--image-size", 256)
    assert session.get_inputs()[0].shape == ["batch", 3, 256, 256]
    facts = session.get_modelmeta().custom_metadata_map
    assert facts == {"model": name, "preset": "paper", "image_size": "256"}
    expected = load_file(GOLDEN / "models" / f"{name}.safetensors")["eval_256"]
    error = worst(session, golden.images(256).numpy(), expected)
    print(f"{name}: off by at most {error:.1e}")
    assert error < 1e-4


@pytest.mark.parametrize("is_by_link", [False, True])
def test_onnx_runtime_computes_the_golden_values_of_polar_reg(is_by_link: bool, polar: ModuleType, tmp_path: Path) -> None:
    model = models.build("polar_reg")
    model.fixed, fixed = torch.nn.Identity(), model.fixed
    polar.set_weights(model)
    model.fixed = fixed
    fixed.array = polar.array_response(16)
    for fact, value in ("mean", polar.MEAN), ("deviation", polar.DEVIATION), ("is_by_link", float(is_by_link)):
        setattr(fixed, fact, torch.tensor(value))
    session = exported(model, tmp_path)
    assert session.get_inputs()[0].shape == ["batch", "ways", 16]
    links = polar.inputs().numpy()
    # Fewer ways of one link, too.
    links[1, :1350] = 0
    with torch.no_grad():
        expected = model.double().eval()(torch.from_numpy(links)).numpy()
    if not is_by_link:
        stored = load_file(GOLDEN / "models" / "polar_reg.safetensors")["eval"]
        assert np.abs(expected[0] - stored[0]).max() < 1e-5
    error = worst(session, links, expected)
    print(f"polar_reg: off by at most {error:.1e}")
    assert error < 1e-4


@pytest.mark.parametrize(("name", "size"), [("vit_reg", 48), ("resnet_conv1d", 72), ("ms_areg", 100), ("radiounet", 32)])
def test_onnx_runtime_computes_what_the_runner_predicts_for_images_of_other_sizes(
    name: str, size: int, golden: ModuleType, data: Path, tmp_path: Path
) -> None:
    session = exported(golden.set_weights(models.build(name, "small")), tmp_path, "--image-size", size)
    examples = ApsDataset(data, "test", size)
    images, _ = examples.batch(np.arange(len(examples)))
    weights, predicted = tmp_path / "weights.safetensors", tmp_path / "spectra.npy"
    run("predict", "--weights", weights, "--data", data, "--image-size", size, "--out", predicted)
    expected = np.load(predicted)
    error = worst(session, images.numpy(), expected)
    print(f"{name}, {size} pixels: off by at most {error:.1e}, values of deviation {expected.std():.1e}")
    assert error < 1e-4 < 1e-2 * expected.std()


def test_a_file_tells_what_its_tensors_are_and_what_the_weights_were_trained_on(tmp_path: Path) -> None:
    exported(models.build("resnet_mlp", "small"), tmp_path)
    graph = onnx.load(tmp_path / "model.onnx").graph
    assert "Gaussian spot at the transmitter" in graph.input[0].doc_string
    assert "normalised as the labels" in graph.output[0].doc_string
    run("export-onnx", "--model", "polar_reg", "--out", tmp_path / "shipped.onnx")
    facts = {fact.key: fact.value for fact in onnx.load(tmp_path / "shipped.onnx").metadata_props}
    assert list(facts) == ["model", "preset", "directions", "kinds", "protocol", "training_statistics", "label"]
    assert "array" in json.loads(facts["label"]) and json.loads(facts["training_statistics"])["std"] > 0


def test_the_python_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    models.save(models.build("ms_mlp", "small"), "weights.safetensors")
    run("export-onnx", "--weights", tmp_path / "weights.safetensors", "--out", tmp_path / "model.onnx")
    exec(compile(blocks("docs/python.md", "test", "onnx"), "docs/python.md", "exec"), {})
