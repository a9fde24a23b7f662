"""Basins: planes of starts, and that they agree with experiments and with single motions."""

import numpy as np
import pytest

from percuss import Bar, Kept, Load, Start, Starts, Stop, System, run
from percuss.errors import ParameterError, PercussError
from percuss.explore.attractors.basin import Basins, basins, basins_job
from percuss.explore.attractors.experiments import experiment
from percuss.explore.family import Axis
from percuss.explore.jobs.carrying_out import carry_out

TURN = 2.0 * np.pi
BISTABLE = System(s=1e6, d=0.0, restitution=0.6, load=Load.fourier([0.6, 1.0, np.exp(1.0j)]))
ELASTIC = System(s=3.0, d=0.05, restitution=0.6, load=Load.harmonic(0.9, 1.0))


def test_the_shares_of_a_box_are_those_of_random_starts_in_it():
    """As many random starts from the box as the image has points: the parts agree within the intervals."""
    n = 70
    grid = basins(
        BISTABLE,
        ("time", TURN / (2 * n), TURN * (1 - 1 / (2 * n)), n),
        ("velocity", -5.0 * (1 - 1 / (2 * n)), -5.0 / (2 * n), n),
        workers=1,
    )

    def uniform(seed):
        draw = np.random.default_rng(seed)
        return Starts.rigid(0.0, -5.0 * draw.random(n * n), TURN * draw.random(n * n))

    random = experiment(BISTABLE, None, uniform, seed=1, workers=1)
    assert [a.label for a in grid.attractors[:2]] == ["z=1/1", "z=1/1"]
    for share in grid.shares[:2]:
        twin = min((s for s in random.shares if s.label == "z=1/1"), key=lambda s: abs(s.phases[0] - share.phases[0]))
        assert twin.phases == pytest.approx(share.phases, abs=1e-6)
        middle, half = twin.share, 0.5 * (twin.high - twin.low)
        assert abs(share.share - middle) < 2.0 * half
    assert sum(attractor.members for attractor in grid.attractors) == n * n


def test_every_point_is_the_motion_from_there():
    found = basins(ELASTIC, ("position", -3.0, 0.0, 4), ("time", [0.0, 2.0, 5.0]), at={"velocity": -0.5}, modes=2)
    assert found.image.shape == found.label.shape == (3, 4)
    for i, time in enumerate((0.0, 2.0, 5.0)):
        for j, position in enumerate((-3.0, -2.0, -1.0, 0.0)):
            assert found.label[i, j] == run(ELASTIC, Start.rigid(position, -0.5, time), modes=2).label
    names = [attractor.label for attractor in found.attractors]
    assert np.array_equal(np.array(names)[found.image], found.label)
    assert found.image.max() == len(names) - 1


def test_modal_amplitudes():
    found = basins(ELASTIC, ("u_1", -0.3, 0.3, 3), Axis.linear("v_2", -0.2, 0.2, 2), at={"position": -1.0}, modes=2)
    for i, v in enumerate((-0.2, 0.2)):
        for j, u in enumerate((-0.3, 0.0, 0.3)):
            start = Start.modal([-1.0 + 2.0 * u, u, 0.0], [0.0, 0.0, v])
            assert found.label[i, j] == run(ELASTIC, start, modes=2).label
    assert found.columns["start_displacement"].shape == (6, 3)
    assert np.allclose(found.columns["position"], -1.0)


def test_a_portion_of_a_huge_plane_is_made_alone():
    """10¹⁰ starts would take 400 GB."""
    n = 100_000
    job = basins_job(ELASTIC, ("time", 0.0, 6.0, n), ("u_2", -0.1, 0.1, n), at={"position": -1.0}, modes=2)
    part = job.starts(n * n - n - 2, n * n - n + 2)
    assert part.time.tolist() == [job.x[1][-2], 6.0, 0.0, job.x[1][1]]
    assert part.displacement[:, 2].tolist() == [job.y[1][-2]] * 2 + [0.1] * 2
    assert np.allclose(part.displacement @ [1.0, -2.0, 2.0], -1.0)
    with pytest.raises(PercussError, match="memory"):
        carry_out(job, workers=1)


def test_what_is_not_done_has_no_number():
    found = basins(BISTABLE, ("time", 0.0, 6.0, 5), ("velocity", -4.0, -0.5, 4), workers=1)
    found.columns["code"][:7] = -1
    part = Basins(found.system, 0, found.stop, found.x, found.y, (), found.columns)
    assert (part.image.reshape(-1)[:7] == -1).all() and (part.image.reshape(-1)[7:] >= 0).all()
    assert (part.label.reshape(-1)[:7] == "").all() and sum(a.members for a in part.attractors) == 13


def test_dataset():
    found = basins(BISTABLE, ("time", 0.0, 6.0, 5), ("velocity", -4.0, -0.5, 4), at={"position": -0.1}, workers=1)
    data = found.dataset
    assert data["attractor_number"].dims == ("velocity", "time") and data["attractor_number"].shape == (4, 5)
    assert data["time"].attrs["units"] == "rad" and data.attrs["at_position"] == -0.1
    assert data["invariants"].dims == ("velocity", "time", "invariant")
    assert np.array_equal(data["attractor_number"], found.image)
    assert "Basins: 5 × 4 starts" in str(found)


def test_the_axes_of_a_dataset_have_scales():
    system = System.from_si(
        Bar(length=0.341, diameter=0.049), Load.harmonic(5e3, 6e3, frequency=60.0), Kept(restitution=0.6)
    )
    data = basins(system, ("time", 0.0, 6.0, 3), ("velocity", -4.0, -0.5, 3), workers=1).dataset
    assert data["time"].attrs == {"units": "rad", "si_scale": system.time_scale, "si_units": "s"}
    assert data["velocity"].attrs["si_scale"] == system.speed_scale
    assert data.attrs["scaling"].startswith("dimensionless")


@pytest.mark.parametrize(
    ("asked", "word"),
    [
        ({"x": ("speed", 0, 1, 3)}, "position, velocity, time"),
        ({"x": ("velocity", 0, 1, 3)}, "another"),
        ({"x": ("position", -1.0, 0.5, 3)}, "wall"),
        ({"x": ("u_3", -1.0, 0.5, 3)}, "modes"),
        ({"x": ("u_0", -1.0, 0.5, 3)}, "u_1"),
        ({"x": "time"}, "name, first"),
        ({"at": {"velocity": 1.0}}, "not on an axis"),
        ({"at": {"place": 1.0}}, "position, velocity, time"),
        ({"at": {"position": 1.0}}, "wall"),
        ({"modes": -1}, "modes"),
        ({"x": Axis.linear("time", 0.0, 6.0, 3, "ms")}, "dimensionless"),
        ({"stop": Stop(impacts=0)}, "impacts"),
    ],
)
def test_bad_planes(asked, word):
    with pytest.raises(ParameterError, match=word):
        basins(ELASTIC, **{"x": ("time", 0.0, 6.0, 3), "y": ("velocity", -1.0, 0.0, 3), "modes": 2, **asked})


def test_pictures_of_a_case_in_si_have_axes_in_si():
    from percuss import plot

    bar = Bar(length=0.09, diameter=0.06)
    system = System.from_si(bar, Load.harmonic(mean=900.0, amplitude=1200.0, frequency=33.0), Kept(restitution=0.3))
    speed = 8.0 / system.speed_scale
    found = basins(system, ("time", 0.1, 6.2, 6), ("velocity", -speed, -0.1 * speed, 5), modes=0, workers=1)
    panel = plot.basins(found).axes[0]
    assert panel.get_xlabel().endswith("[ms]") and panel.get_ylabel() == "velocity of the start [m/s]"
    assert panel.get_ylim()[0] == pytest.approx(-8.9) and 30.0 < panel.get_xlim()[1] < 34.0
    starts = plot.experiment(experiment(system, 40, modes=0, workers=1)).axes[1]
    assert starts.get_xlabel().endswith("[ms]") and "[m/s]" in starts.get_ylabel()
    plain = plot.basins(basins(ELASTIC, ("time", 0.1, 6.2, 4), ("position", -3.0, -0.1, 3), modes=0, workers=1)).axes[0]
    assert plain.get_xlabel() == "load phase of the start [rad]" and "[bar lengths]" in plain.get_ylabel()
