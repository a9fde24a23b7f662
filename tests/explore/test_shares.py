"""Shares over a parameter: each value is an experiment, and the attractors of one label are lines."""

import math
from pathlib import Path

import numpy as np
import pytest

from percuss import Load, System
from percuss.errors import Interrupted, ParameterError
from percuss.explore import Archive, Shares, experiment, shares
from percuss.model import Kept, Machine, Port, UniformBar, Valve

PNEUMATIC = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
TWINS = System(s=1e6, d=0.0, restitution=0.6, load=Load.fourier([0.6, 1.0, np.exp(1.0j)]))
VALVE = Valve({"return": -0.4, "power": 1.8}, (Port("power", behind=1.0, side="back"), Port("return", on="impact")))
ASK = {"starts": 120, "seed": 3, "modes": 0}


def test_each_value_is_an_experiment() -> None:
    found = shares(PNEUMATIC, "load_factor=0.66:0.8:4", **ASK, workers=1)
    for value, one in zip(found.axis.values.tolist(), found.experiments, strict=True):
        alone = experiment(PNEUMATIC.with_load_factor(value), 120, seed=3, modes=0, workers=1)
        assert one.shares == alone.shares
    table, dataset = found.to_pandas(), found.to_xarray()
    assert table.groupby("load_factor").members.sum().tolist() == [120] * 4
    for row in table.itertuples():
        here = dataset.sel(load_factor=row.load_factor, line=row.line)
        assert (float(here.share), float(here.low), int(here.members)) == (row.share, row.low, row.members)
        assert str(here.label.item()) == row.label
    assert dataset.share.sum("line").values == pytest.approx(1.0)
    assert str(found).startswith("Shares: 4 values of load_factor from 0.66 to 0.8, 120 starts each, 0 modes")


def test_attractors_of_one_label_are_lines_by_where_they_are() -> None:
    found = shares(TWINS, "restitution=0.59:0.6:3", **ASK, workers=1)
    twins = [line for label, line in zip(found.labels, found.lines, strict=True) if label == "z=1/1"]
    assert len(twins) == 2
    for line in twins:
        phases = [one.shares[k].phases[0] for one, k in zip(found.experiments, line, strict=True)]
        assert np.abs(np.exp(1j * np.diff(phases)) - 1.0).max() < 0.2
    first = [twin[0] for twin in twins]
    apart = [found.experiments[0].shares[k].phases[0] for k in first]
    assert abs(math.remainder(apart[0] - apart[1], 2.0 * math.pi)) > 0.5


def test_machines_and_families_too() -> None:
    found = shares(Machine(UniformBar(20.0), VALVE, Kept(0.2)), ("restitution", [0.1, 0.2]), 20, modes=0, workers=1)
    assert "runs 1/1" in found.labels and found.members.sum() == 40


def test_kept_interrupted_and_gone_on_with(tmp_path: Path) -> None:
    place, whole = tmp_path / "shares.zarr", shares(PNEUMATIC, "load_factor=0.66:0.8:3", **ASK, workers=1)
    with pytest.raises(Interrupted):
        shares(
            PNEUMATIC, "load_factor=0.66:0.8:3", **ASK, workers=1, archive=place, chunk=50,
            progress=lambda now: now.done >= 100,
        )  # fmt: skip
    again = shares(PNEUMATIC, "load_factor=0.66:0.8:3", **ASK, workers=1, archive=place, resume=True)
    assert again.members.tolist() == whole.members.tolist() == Archive.open(place).result().members.tolist()
    whole.save(tmp_path / "shares.nc")
    read = Shares.load(tmp_path / "shares.nc")
    assert read.members.tolist() == whole.members.tolist() and read.labels == whole.labels
    assert [one.shares for one in read.experiments] == [one.shares for one in whole.experiments]


def test_refused() -> None:
    with pytest.raises(ParameterError, match="one of"):
        shares(PNEUMATIC, "nonsense=0:1:3", **ASK)
    with pytest.raises(ParameterError, match="along"):
        shares(PNEUMATIC, 3.0, **ASK)  # type: ignore[arg-type]
