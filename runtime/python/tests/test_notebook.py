from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[3]
NOTEBOOK = ROOT / "runtime/python/notebooks/mission-to-comparison.ipynb"


def test_the_notebook_runs_from_a_mission_to_a_comparison(plugins, monkeypatch, tmp_path):
    monkeypatch.setenv("BACKSEAT_ROOT", str(ROOT))
    monkeypatch.setenv("BACKSEAT_PLUGINS", str(plugins))
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert len(notebook.cells) == 10
    # What was printed belongs to no commit.
    assert not any(cell.get("outputs") for cell in notebook.cells)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    printed = "".join(output["text"] for output in outputs if output["output_type"] == "stream")
    assert "isobath, seed 1: completed" in printed and "slower is better by 0." in printed, printed
    plots = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(plots) == 2
