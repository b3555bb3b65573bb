from pathlib import Path

import pytest

import map2aps
from pages import blocks


@pytest.mark.parametrize("page", ["README.md", "docs/python.md"])
def test_the_python_of_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks(page, "test"), page, "exec"), {})


def test_the_first_lines_of_the_package_are_true() -> None:
    import doctest

    assert doctest.testmod(map2aps).failed == 0
