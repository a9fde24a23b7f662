"""The scripts of the gallery by themselves, without the settings of the documentation: nothing is cut off."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

matplotlib = pytest.importorskip("matplotlib")

SCRIPTS = sorted((Path(__file__).parents[2] / "docs" / "gallery").glob("plot_*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_no_label_is_cut_off(script, monkeypatch):
    import matplotlib.pyplot as plt

    monkeypatch.setattr(plt, "show", lambda: None)
    plt.switch_backend("agg")
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        plt.close("all")
        runpy.run_path(str(script))
        (number,) = plt.get_fignums()
        figure = plt.figure(number)
        figure.canvas.draw()
        whole = figure.bbox
        sides = [side for axes in figure.axes for side in (axes.xaxis, axes.yaxis)]
        ticks = {label for side in sides for label in side.get_ticklabels(which="both")}  # some are beyond the limits
        for text in set(figure.findobj(matplotlib.text.Text)) - ticks:
            if text.get_text().strip() and text.get_visible() and text.get_in_layout():
                box = text.get_window_extent()
                assert whole.x0 - 1 <= box.x0 and box.x1 <= whole.x1 + 1, text.get_text()
                assert whole.y0 - 1 <= box.y0 and box.y1 <= whole.y1 + 1, text.get_text()
        plt.close("all")
