from pathlib import Path

import pytest

from map2aps import _native

SHIPPED = Path(__file__).parents[2] / "crates" / "aps-model" / "shipped"


def test_everything_that_is_shipped_comes_with_the_package() -> None:
    names = sorted(folder.name for folder in SHIPPED.iterdir())
    assert len(names) > 1
    for name in names:
        weights, settings = _native.shipped(name)
        assert weights == (SHIPPED / name / "weights.safetensors").read_bytes()
        assert settings == (SHIPPED / name / "config.json").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match=f"only of {', '.join(names)}$"):
        _native.shipped("none")
