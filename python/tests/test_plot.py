"""Plots, and the notebook that shows them."""

import subprocess
import sys

import numpy as np
import pytest

import ferrule
from conftest import ROOT

pyplot = pytest.importorskip("matplotlib.pyplot")
pyplot.switch_backend("agg")


def test_an_episode_is_drawn_as_it_went(episodes, tmp_path):
    episode = ferrule.Episode(sorted(episodes.glob("*.h5"))[0])
    figure = ferrule.plot.episode(episode)
    depth, felt, acting = figure.axes
    assert (depth.lines[0].get_ydata() == -1e6 * episode.states[:, 0]).all()
    assert [line.get_label() for line in felt.lines] == ["$F_x$", "$F_y$", "$F_z$"]
    drawn = {line.get_label().replace(" ", "_") for line in acting.lines}
    assert drawn == {term for term in ferrule.terms if np.any(episode.force(term))}
    figure.savefig(tmp_path / "episode.png")
    pyplot.close(figure)


def test_an_evaluation_is_drawn_trial_by_trial(tmp_path):
    result = ferrule.evaluate("constant-velocity", "bench", trials=20)
    figure = ferrule.plot.evaluation(result)
    ends, each = figure.axes
    assert sum(bar.get_height() for bar in ends.patches) == 20
    drawn = np.concatenate([points.get_offsets() for points in each.collections])
    assert sorted(drawn[:, 1]) == sorted(1e6 * result.peak_force_N)
    figure.savefig(tmp_path / "evaluation.png")
    pyplot.close(figure)


def test_forces_are_drawn_over_the_gap(tmp_path):
    figure = ferrule.plot.forces("paper", gap_nm=[1, 10, 100], length_um=50)
    expected = ferrule.forces("paper", gap_nm=[1, 10, 100], length_um=50)
    lines = {line.get_label().replace(" ", "_"): line for line in figure.axes[0].lines}
    assert set(lines) == {name for name, force in expected.items() if force.any()}
    attraction = 1e6 * np.abs(expected["van_der_waals"])
    np.testing.assert_allclose(lines["van_der_waals"].get_ydata(), attraction)
    pyplot.close(figure)
    figure = ferrule.plot.forces("bench")
    figure.savefig(tmp_path / "forces.png")
    pyplot.close(figure)


def test_without_matplotlib_the_extra_is_named():
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "import ferrule\n"
        "try: ferrule.plot.forces()\n"
        "except ImportError as error: assert 'ferrule[plot]' in str(error)\n"
        "else: sys.exit(1)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.filterwarnings("ignore")  # of what runs it
def test_the_notebook_runs_from_a_recording_to_pictures(tmp_path):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    notebook = nbformat.read(ROOT / "examples/insertion.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    where = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(notebook, timeout=300, resources=where).execute()
    shown = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in data for data in shown) == 3
    printed = "".join(o.get("text", "") for c in notebook.cells for o in c.get("outputs", []))
    assert "inserted" in printed
