import subprocess
import sys
from pathlib import Path

import pytest
import torch

import map2aps.torch
from docstrings import gaps
from map2aps.torch import models
from pages import ROOT, blocks


def test_the_torch_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks("docs/python.md", "test", "torch"), "docs/python.md", "exec"), {})


def test_every_public_name_of_torch_tells_what_it_takes_and_gives() -> None:
    assert gaps(map2aps.torch) + gaps(models) == []


def test_the_parts_of_models_say_what_they_are() -> None:
    parts = [of for of in vars(models).values() if getattr(of, "__module__", None) == models.__name__]
    silent = [of.__qualname__ for of in parts if callable(of) and not of.__doc__]
    modules = [of for of in parts if isinstance(of, type) and issubclass(of, torch.nn.Module)]
    assert len(modules) == 14
    silent += [f"{of.__qualname__}.forward" for of in modules if not vars(of)["forward"].__doc__]
    assert silent == []


def test_the_example_that_takes_features_away_prints_its_table(data: Path) -> None:
    command = [sys.executable, str(ROOT / "docs" / "examples" / "polar_features.py"), str(data), "--steps", "2", "--batch", "16", "--links", "12"]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    rows = [line for line in printed.splitlines() if line.startswith("| ")]
    assert len(rows) == 14 and "| nothing |" in printed and "nan" not in printed
