"""Sections of motions against a look at every moment, and motions begun from a state of another one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from percuss import Load, Start, Stop, System, run
from percuss.errors import ParameterError, PercussError
from percuss.model import Kept, Machine, ModalBody, Port, Supply, UniformBar, Valve
from percuss.steady import orbits

TURN = 2.0 * math.pi
BAR = System(s=5.0, d=0.02, restitution=0.6, load=Load.harmonic(0.6, 1.0))
STEPS = System(s=3.0, d=0.1, restitution=0.4, load=Load.steps([0.8, 1.9, 3.3, 4.5], [-0.7, -0.1, 0.8, 1.5]))
HELD = System(ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 0.3), Load.harmonic(0.2, 1.0), Kept(0.7))
SLIDERS = (Port("power", behind=0.6, side="back", delay=0.3), Port("return", behind=0.2, side="front", delay=0.4))
VALVE = Valve({"return": -0.4, "power": 1.8}, SLIDERS)
MACHINE = Machine(UniformBar(20.0), VALVE, Kept(0.3))
FED = Machine(UniformBar(20.0), replace(VALVE, supply=Supply(0.7, 15.0)), Kept(0.3))
QUICKENED = FED.with_valve(replace(VALVE, supply=Supply(0.7, 15.0, quickening=0.8)))


def free(system, modes, time=60.0, start=None):
    return run(system, start, modes=modes, stop=Stop(time=time, impacts=10**6, periodic=False))


@pytest.mark.parametrize(("hammer", "modes"), [(BAR, 3), (STEPS, 2), (HELD, 2), (MACHINE, 2), (FED, 0)])
@pytest.mark.parametrize("asked", ["displacement", "velocity"])
def test_crossings_are_those_of_a_look_at_every_moment(hammer, modes, asked):
    motion = free(hammer, modes, 20.0)
    t = np.linspace(motion.begin_time, motion.end_time, 400_001)
    seen = (motion.position if asked == "displacement" else motion.bar_velocity)(1.0 if modes else 0.3, t)[0]
    value = float(0.5 * (seen.min() + seen.max()) - 0.1 * np.ptp(seen))
    edges = np.searchsorted(t, motion.events.time)
    for direction in ("rising", "falling", "both"):
        found = motion.section(**{asked: value}, at=1.0 if modes else 0.3, direction=direction)
        off = seen - value
        crossed = np.flatnonzero((off[:-1] < 0.0) != (off[1:] < 0.0))
        crossed = crossed[~np.isin(crossed + 1, edges) | (asked == "displacement")]
        crossed = crossed if direction == "both" else crossed[(off[crossed] < 0.0) == (direction == "rising")]
        assert len(found) == crossed.size and (len(found) or direction != "both")
        assert found.times == pytest.approx(t[crossed], abs=2e-4)
        at = found.position if asked == "displacement" else found.speed
        assert at == pytest.approx(value, abs=1e-9 * np.ptp(seen))


def test_a_touch_between_two_looks_is_two_crossings():
    """The wall of a section is set just below the top of a flight, which a look every 0.01 periods passes by."""
    motion = free(BAR, 0, 30.0)
    lowest = float(motion.gap(np.linspace(2.0, 30.0, 200_001)).min())
    for depth in (1e-3, 1e-6, 1e-8):
        assert len(motion.section(displacement=lowest + depth)) >= 2


def test_the_section_of_a_periodic_motion_is_its_points():
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    orbit = next(one for one in orbits(system, 2, 2, modes=1, tries=200) if one.stable)
    motion = run(system, Start.orbit(orbit), modes=1, stop=Stop(time=40 * TURN, impacts=10**6, periodic=False))
    strobe, struck = motion.section(phase=1.0), motion.section(event="impact", side="left")
    assert np.diff(strobe.times) == pytest.approx(TURN, abs=1e-9) and strobe.phases == pytest.approx(1.0, abs=1e-9)
    for section in (strobe, struck):
        assert section.displacement[2:] == pytest.approx(section.displacement[:-2], abs=1e-8)
        assert np.abs(section.displacement[1:] - section.displacement[:-1]).max() > 1e-4
    assert struck.speed == pytest.approx(motion.blow_speeds, rel=1e-9)
    table, dataset = strobe.to_pandas(), strobe.to_xarray()
    assert list(table) == ["time", "phases", "position", "speed", "u_0", "u_1", "v_0", "v_1"]
    assert dataset.velocity.shape == (len(strobe), 2) and dataset.time.values.tolist() == table.time.tolist()


def test_sections_of_machines_have_valve_and_pressure():
    motion = free(FED, 2, 30.0)
    at_ports = motion.section(event="port")
    assert set(at_ports.state) == {"return", "power"} and at_ports.phases is None
    assert at_ports.pressure == pytest.approx(motion.pressure(at_ports.times), rel=1e-12)
    with pytest.raises(ParameterError, match="keeps time"):
        motion.section(phase=0.0)


def test_what_is_no_section():
    motion = free(BAR, 0, 10.0)
    for asked in ({}, {"phase": 0.0, "event": "impact"}, {"displacement": 0.0}, {"event": "port"}, {"velocity": "a"}):
        with pytest.raises(ParameterError):
            motion.section(**asked)


@pytest.mark.parametrize(
    ("hammer", "modes"),
    [(BAR, 3), (STEPS, 2), (HELD, 2), (MACHINE, 0), (MACHINE, 3), (FED, 0), (FED, 2), (QUICKENED, 0), (QUICKENED, 2)],
)
def test_a_motion_begun_from_a_state_goes_on_as_it_did(hammer, modes):
    motion = free(hammer, modes, 40.0)
    for at in (3.3, 7.1, float(motion.events.time[2]), float(motion.events.time[3])):
        again = free(hammer, modes, 6.0, motion.start_at(at))
        t = np.linspace(at + 1e-6, at + 6.0, 301)
        size = np.ptp(motion.gap(t))
        assert again.gap(t) == pytest.approx(motion.gap(t), abs=1e-7 * size)
        assert again.bar_velocity(1.0, t)[0] == pytest.approx(motion.bar_velocity(1.0, t)[0], abs=1e-4)


def test_a_state_starts_another_system():
    motion = free(BAR, 2)
    start = motion.start_at(12.0)
    other = run(BAR.with_load_factor(0.8), start, modes=2, stop=Stop(time=5.0, impacts=99, periodic=False))
    assert other.gap([12.0]) == pytest.approx(motion.gap([12.0]), abs=1e-12)
    for modes in (1, 3):
        with pytest.raises(ParameterError, match="2, of which the start has the amplitudes"):
            run(BAR, start, modes=modes)
    with pytest.raises(ParameterError, match="amplitudes"):
        run(BAR, Start.modal([-1.0, 0.1]), modes=4)


def test_what_no_start_can_tell():
    system = System(
        ModalBody((3.3, 7.3), (0.3, 0.1), (1.0, 0.8), (1.0, -0.5), -0.01), Load.harmonic(0.0, 1.0), Kept(0.4)
    )
    motion = run(system, Start.rigid(-1.0), stop=Stop(time=30.0, periodic=False))
    rest = float(motion.events.of("rest").time[0])
    with pytest.raises(PercussError, match="rests"):
        motion.start_at(rest + 1e-3)
