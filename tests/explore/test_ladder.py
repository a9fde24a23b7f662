"""The ladder z=1/1, 2/1, 3/1 … of a rigid bar: each touches the wall where the next begins, up to chatter."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from percuss import Load, System
from percuss.explore import Branch, SystemFamily, follow
from percuss.steady import PeriodicOrbit, orbits

HAMMER = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.45, 1.0))
RUNGS = (0.399313, 0.527910, 0.581287, 0.605194, 0.616224, 0.621385, 0.623820, 0.624975, 0.625527)
WINDOWS = {
    2: (0.659282, 0.673754), 3: (0.631808, 0.635221), 4: (0.625261, 0.626612), 5: (0.624230, 0.624883),
    6: (0.624539, 0.624883), 9: (0.625678, 0.625737),
}  # fmt: skip
ONSET = 0.626037331650


def rungs() -> Iterator[Branch]:
    """z=1/1 … 9/1 over the mean load, each from a point of the branch that begins at the touch of the one before."""
    family, orbit, value = SystemFamily(HAMMER), orbits(HAMMER, 1, 1, modes=0).orbits[0], 0.45
    for impacts in range(1, 10):
        branch = follow(orbit, "mean", (0.35, 0.7), family=family, value=value, switch=1)
        assert branch.label == f"z={impacts}/1"
        yield branch
        (longer,) = [one for one in branch.switched if one.label == f"z={impacts + 1}/1"]
        inside = longer.values.size // 2
        value = float(longer.values[inside])
        times = tuple(longer.times[inside].tolist())
        orbit = PeriodicOrbit(family.system({"mean": value}), 1, times, 0).from_first


def number(branch: Branch, kind: str) -> float:
    """The value of the only point of a kind."""
    (value,) = [point.value for point in branch.points if point.kind.value == kind]
    return value


@pytest.mark.slow
def test_it_is_climbed_to_nine_impacts() -> None:
    begins = None
    touches = []
    for impacts, branch in enumerate(rungs(), 1):
        touches.append(number(branch, "grazing_touch"))
        if begins is not None:
            assert number(branch, "grazing_impact_dies") == pytest.approx(begins, rel=0, abs=1e-11)
        if impacts in WINDOWS:
            flip, fold = number(branch, "flip"), number(branch, "fold")
            assert (flip, fold) == pytest.approx(WINDOWS[impacts], rel=0, abs=1e-6)
            stable = branch.values[branch.stable]
            assert stable.size and flip - 1e-9 <= stable.min() <= stable.max() <= fold + 1e-9
        begins = touches[-1]
    assert touches == pytest.approx(RUNGS, rel=0, abs=1e-6)
    left = ONSET - np.array(touches)
    assert np.all(left > 0.0)
    assert np.all(left[5:] < 0.5 * left[4:-1])  # they pile up at the onset of chatter
