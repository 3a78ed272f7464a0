"""The notebook runs from top to bottom on a finished run, and shows what it says."""

from pathlib import Path

import nbformat
from nbclient import NotebookClient

from tests.workflow.workspace import ROOT

NOTEBOOK = ROOT / "notebooks/look.ipynb"


def test_the_notebook_shows_a_scene_a_demonstration_and_a_policy(run: Path) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(notebook, resources={"metadata": {"path": str(run)}}, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = [kind for output in outputs for kind in output.get("data", {})]
    assert shown.count("image/png") == 3, "the scene, the demonstration, the policy"
    assert shown.count("text/html") == 2, "the table of objects, the scene to turn"
    assert "success after" in "".join(output.get("text", "") for output in outputs)


def test_no_outputs_are_committed() -> None:
    cells = nbformat.read(NOTEBOOK, as_version=4).cells
    assert [cell.outputs for cell in cells if cell.cell_type == "code" and cell.outputs] == []
