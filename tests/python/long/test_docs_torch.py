from pathlib import Path

import pytest

from pages import blocks


def test_the_torch_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks("docs/python.md", "test", "torch"), "docs/python.md", "exec"), {})
