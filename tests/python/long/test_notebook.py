"""The notebook of the guide, run from its first cell to its last."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from pages import ROOT

NOTEBOOK = ROOT / "docs" / "notebooks" / "city-to-score.ipynb"


def kinds(notebook: nbformat.NotebookNode) -> list[list[str]]:
    """Outputs of each cell: the name of a stream, or the richest type of an output."""
    return [
        [output.get("name") or sorted(output.data, key=lambda kind: kind != "image/png")[0] for output in cell.get("outputs", [])]
        for cell in notebook.cells
    ]


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_notebook_runs_and_shows_what_it_is_kept_with(tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    kept = kinds(notebook)
    assert sum(shown.count("image/png") for shown in kept) >= 6
    NotebookClient(notebook, timeout=1200, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert kinds(notebook) == kept


def test_the_notebook_is_small_and_names_no_place_of_the_machine_that_ran_it() -> None:
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert len(text) < 400_000
    assert "/tmp" not in text and "/home" not in text
