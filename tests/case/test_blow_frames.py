"""A blow as pictures in time: the sizes that they are drawn with."""

from __future__ import annotations

import numpy as np
import pytest

from percuss.case.answers.exploring.playback import blow_playback
from percuss.case.case import case_of


@pytest.mark.parametrize("speed, ratio", [(20.0, 1.5), (7.0, 0.4)])
def test_in_a_dimensionless_rod_waves_are_as_fast_as_in_the_bar(speed: float, ratio: float) -> None:
    """Both fronts are as far from the struck face, at every moment of the first transit."""
    tables = {
        "system": {"s": speed, "d": 0.005, "restitution": 0.4},
        "load": {"kind": "harmonic", "mean": 0.6, "amplitude": 1.0},
        "tool": {"impedance": ratio},
        "blow": {"velocity": 2.0},
    }
    found = blow_playback(case_of(tables, "test"), frames=61, cells=400)
    assert found.header["striker"]["lengths"] == pytest.approx([1.0])
    assert found.header["rod"]["lengths"] == pytest.approx([found.arrays["rod_edges"][-1]])
    early = np.flatnonzero((found.arrays["t"] > 0.1 / speed) & (found.arrays["t"] < 0.9 / speed))
    assert early.size > 5
    for frame in early:
        own, rod = (np.flatnonzero(found.arrays[f"{body}_stress"][frame]) for body in ("striker", "rod"))
        behind = 1.0 - found.arrays["striker_edges"][own[0]]
        assert found.arrays["rod_edges"][rod[-1] + 1] == pytest.approx(behind, abs=0.01)
        assert behind == pytest.approx(found.arrays["t"][frame] * speed, abs=0.01)
