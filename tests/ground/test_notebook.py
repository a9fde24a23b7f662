"""A progress bar in notebooks: in a real kernel, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from percuss import Load, Starts, System
from percuss import short_repr as notebook
from percuss.explore.jobs.progress import JobProgress
from percuss.simulate import simulate_many

CODE = """
import time
from percuss import short_repr
from percuss.explore.jobs.carrying_out import carry_out
from percuss.explore.jobs.job import Column
import numpy as np

class Slow:
    size, columns, ask = 6, {"square": Column()}, {"kind": "squares", "size": 6}

    def compute(self, first, last, stopped):
        time.sleep(0.3)
        stopped()
        return {"square": np.arange(first, last) ** 2.0}

print(carry_out(Slow(), workers=1, chunk=1)["square"])
"""


def test_a_long_call_shows_a_bar_in_a_notebook_and_takes_it_away():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CODE)])
    seen = []
    client = nbclient.NotebookClient(book, timeout=120, kernel_name="python3")
    process = client.process_message

    def spy(message, cell, index):
        seen.append((message["msg_type"], message["content"].get("data", {}).get("text/html", "")))
        return process(message, cell, index)

    client.process_message = spy
    client.execute()
    bars = [text for kind, text in seen if kind in ("display_data", "update_display_data")]
    assert any("<progress" in text and "left" in text for text in bars)
    assert bars[-1] == ""
    assert any("25." in str(output) for output in book.cells[0].outputs)


def test_nothing_is_shown_elsewhere(capsys):
    assert not notebook.in_notebook()
    with notebook.watched(None) as watch:
        assert watch is None
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    simulate_many(system, Starts.rigid(-np.ones(3)), modes=0)
    assert capsys.readouterr() == ("", "")


def test_who_watches_is_left_alone_and_one_bar_is_enough(monkeypatch):
    monkeypatch.setattr(notebook, "in_notebook", lambda: True)
    with notebook.watched(print) as watch:
        assert watch is print
    with notebook.watched(None) as outer:
        assert outer is not None
        with notebook.watched(None) as inner:
            assert inner is None
        outer(JobProgress(1, 2, 1.0, 1.0, 0))  # too early to draw
    with notebook.watched(None) as again:
        assert again is not None
