from pathlib import Path

import pytest
import torch

import map2aps.torch
from docstrings import gaps
from map2aps.torch import models
from pages import blocks


def test_the_torch_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks("docs/python.md", "test", "torch"), "docs/python.md", "exec"), {})


def test_every_public_name_of_torch_tells_what_it_takes_and_gives() -> None:
    assert gaps(map2aps.torch) + gaps(models) == []


def test_the_parts_of_models_say_what_they_are() -> None:
    parts = [of for of in vars(models).values() if getattr(of, "__module__", None) == models.__name__]
    silent = [of.__qualname__ for of in parts if callable(of) and not of.__doc__]
    modules = [of for of in parts if isinstance(of, type) and issubclass(of, torch.nn.Module)]
    assert len(modules) == 15
    silent += [f"{of.__qualname__}.forward" for of in modules if not vars(of)["forward"].__doc__]
    assert silent == []
