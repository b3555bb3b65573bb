"""Weights of models on their way between Rust and PyTorch, trained on either side."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
import torch

import map2aps
from map2aps.torch import ApsDataset, models
from pages import ROOT


def run(*words: object) -> None:
    command = ["cargo", "run", "--quiet", "--package", "xtask-models", "--", *map(str, words)]
    subprocess.run(command, cwd=ROOT, check=True)


def predicted(weights: Path, *words: object) -> np.ndarray:
    out = weights.with_name("spectra.npy")
    run("predict", "--weights", weights, "--out", out, *words)
    return np.load(out)


def worst(model: torch.nn.Module, conditions: torch.Tensor, expected: np.ndarray) -> float:
    """Largest difference, in standard deviations of the spectra."""
    with torch.no_grad():
        found = model.eval()(conditions).numpy()
    assert found.shape == expected.shape and np.isfinite(expected).all()
    return float(np.abs(found - expected).max() / expected.std())


@pytest.mark.parametrize("name", [name for name in models.MODELS if name != "polar_reg"])
def test_weights_of_pytorch_predict_the_same_in_rust(name: str, data: Path, tmp_path: Path) -> None:
    torch.manual_seed(1)
    examples = ApsDataset(data, "test")
    images, _ = examples.batch(np.arange(len(examples)))
    model = models.build(name, "small")
    # Running means and variances, and weights, of some training.
    optimizer = torch.optim.SGD(model.parameters(), lr=1e-3)
    for _ in range(3):
        optimizer.zero_grad()
        model(images).square().mean().backward()
        optimizer.step()
    weights = tmp_path / "weights.safetensors"
    models.save(model, weights)
    assert worst(model, images, predicted(weights, "--data", data, "--split", "test")) < 1e-4


@pytest.mark.parametrize("name", ["resnet_mlp", "polar_reg"])
def test_what_pytorch_keeps_beside_weights_reaches_rust(name: str, data: Path, tmp_path: Path) -> None:
    torch.manual_seed(1)
    is_polar = name == "polar_reg"
    examples = ApsDataset(data, "test", size=32, condition="polar" if is_polar else "image")
    conditions, _ = examples.batch(np.arange(len(examples)))
    model = models.build(name, "small", data=data)
    weights = tmp_path / "run" / "weights.safetensors"
    models.save(model, weights, image_size=None if is_polar else 32)
    # Images of 32 pixels, which nothing but the settings tells.
    assert worst(model, conditions, predicted(weights, "--data", data, "--split", "test")) < 1e-4
    other = map2aps.make_dataset(tmp_path / "paper", 3, tx_per_map=1, rx_per_map=2, protocol="paper", progress=None)
    with pytest.raises(subprocess.CalledProcessError):
        predicted(weights, "--data", other.path, "--split", "test")


@pytest.mark.parametrize("name", list(models.MODELS))
def test_weights_trained_in_rust_predict_the_same_in_pytorch(name: str, data: Path, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run("train", "--data", data, "--model", name, "--epochs", 1, "--limit", 24, "--batch", 8, "--out", folder)
    model = models.load(folder / "best.safetensors")
    assert model.settings["training_statistics"]["std"] > 0
    assert model.kind == f"{name} small"
    examples = ApsDataset(data, "test", condition="polar" if name == "polar_reg" else "image")
    conditions, _ = examples.batch(np.arange(len(examples)))
    expected = predicted(folder / "best.safetensors", "--data", data, "--split", "test")
    assert worst(model, conditions, expected) < 1e-4
