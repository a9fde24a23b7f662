"""A machine that switches its own valve with every contact resolved by waves: `run_valve_by_waves`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from percuss.blow.bodies import Rod, rod_sections, striker_sections
from percuss.blow.kernels.lattice_motion import follow_valve
from percuss.blow.kernels.lattice_records import VALVE, LatticeValve
from percuss.blow.periods.lattice import Lattice, LatticeUnits, train_record
from percuss.blow.periods.wave_motion import Impacts, LatticeRun, impacts_of
from percuss.errors import ParameterError
from percuss.halting import check_interrupted
from percuss.mechanics.oil import OilMachine
from percuss.mechanics.oil_records import CHAMBERS
from percuss.model import Load, Machine
from percuss.model.checks import Array, callback, count, instance, non_negative, positive
from percuss.short_repr import ShortRepr, watched
from percuss.simulate import Progress

_TURN = 2.0 * math.pi
_WAYS = 200.0  # transit times of the striker in a turn of the lattice
_AT_ONCE = 1 << 18
_MAIN = 0.5  # of the greatest impulse: what gives as much is a blow
_ALIKE = 1e-3  # scatter of impulses and intervals within which blows are alike
_PATIENCE = 1000  # turns without a blow after which it is said to stall


@dataclass(frozen=True)
class ValveWaves(ShortRepr):
    """A machine that switches its own valve, blow by blow, by waves; in SI.

    Attributes
    ----------
    machine, target
        What moves, and what it strikes. The contact law of the machine has no part in this.
    impacts
        In the units of `units`; see `Impacts`. `velocity` is the mean velocity when the first contact begins.
    time
        How long it was followed, s.
    outcome
        "impacts", "time", "stalls" (no blow came for a long time) or "interrupted".
    taken
        Energy from the supply, J.
    """

    machine: Machine
    target: Rod
    lattice: Lattice
    units: LatticeUnits
    impacts: Impacts
    time: float
    outcome: str
    taken: float

    @cached_property
    def main(self) -> Impacts:
        """The blows of the later half: impacts of half the greatest impulse or more."""
        own = self.impacts.part(slice(self.impacts.size // 2, None))
        return own.part(own.impulse >= _MAIN * own.impulse.max(initial=0.0))

    @property
    def rate(self) -> float:
        """Blows per second over them; NaN with fewer than two."""
        own = self.main
        return (own.size - 1) / float(own.start[-1] - own.start[0]) * self.units.rate if own.size > 1 else math.nan

    @property
    def scatter(self) -> float:
        """(max − min)/mean of their impulses or of the times between them, whichever is greater."""
        own = self.main
        if own.size < 3:
            return math.nan
        return max(float(np.ptp(each) / np.mean(each)) for each in (own.impulse, np.diff(own.start)))

    @property
    def label(self) -> str:
        """ "one blow in a cycle", "irregular", or "none" without blows."""
        if not self.impacts.size:
            return "none"
        return "one blow in a cycle" if self.scatter <= _ALIKE else "irregular"

    @property
    def restitutions(self) -> Array:
        """−V_1/V_0 of the blows."""
        return np.asarray(-self.main.mean_after / self.main.mean_before)

    @property
    def velocities(self) -> Array:
        """Mean velocities of the striker as the blows begin, m/s."""
        return np.asarray(self.main.mean_before * self.units.rate * self.units.length)

    @property
    def stands(self) -> bool | None:
        """Whether the bit is on the rock at every blow; None without a feed."""
        return None if self.target.feed is None else bool(self.main.stands.all())

    @property
    def left_bound(self) -> float | None:
        """√(E_left/W_load) as of `WaveMotion`, the greatest of the blows; None without feed or rock."""
        if self.target.feed is None or self.target.rock is None:
            return None
        own, rock = self.main, self.target.rock
        deep = own.fed * self.units.length / max(1.0 - rock.unloading_ratio, 1e-9)
        loads = 0.5 * rock.stiffness * deep[deep > 0.0] ** 2
        left = own.energy_left[deep > 0.0] * self.units.energy
        return float(np.sqrt(left / loads).max()) if loads.size else None


def run_valve_by_waves(
    machine: Machine,
    target: Rod,
    gap: float,
    *,
    blows: int = 200,
    most_time: float | None = None,
    cells: int = 200,
    progress: Callable[[Progress], object] | None = None,
) -> ValveWaves:
    """A machine that switches its own valve, from rest behind its tool on, every contact by waves.

    The valve drives the striker of `run_by_waves`: its force in each step of the lattice is that of the state, of the
    supply's pressure and of the gas, and ports and orders are timed within a step. Ports read the centre of mass, from
    where it is when the end touches the tool at rest; the housing follows the tool. A blow demands as its first contact
    ends.

    Parameters
    ----------
    machine, target
        In SI, and a rod of sections; with a `Feed`, or on rock, against which it is laid after each blow without one.
    gap
        In m from the tool, where the striker is at rest at the start.
    blows, most_time
        When to end: after so many impacts, or so many seconds.
    cells
        Of the striker, at least.
    progress
        Called now and then with a `percuss.simulate.Progress`; the motion ends when it returns something true.

    Raises
    ------
    ParameterError
        For a machine without sizes, ports that read another place than the centre, gas without oil in the line, and
        other rods.
    """
    instance("machine", machine, Machine)
    instance("target", target, Rod)
    if machine.bar is None:
        raise ParameterError("machine", "dimensionless", "a machine made from SI", "use Machine.from_si")
    if target.impedance is not None or target.end == "free":
        raise ParameterError("target", target.end, "a rod of sections that its end holds", "describe it in [tool]")
    gap, most_time = non_negative("gap", gap), None if most_time is None else positive("most_time", most_time)
    number, size = count("blows", blows, 1, 100_000), count("cells", cells, least=16, most=100_000)
    callback("progress", progress)
    own, rod, bar = striker_sections(machine.bar), rod_sections(target, machine.bar), machine.bar
    rate = _TURN / (_WAYS * float(own.transit.sum()))
    asked = LatticeUnits(bar.mass, rate, bar.length)
    lattice, record, units = train_record(own, target, rod, asked, size, bar.body(rate).damping)
    record = record._replace(load_at=machine.at)
    valve = _valve(machine, asked, units)
    run, state = LatticeRun(record, gap / units.length), np.zeros(1, VALVE)
    names = [name for name, _ in machine.valve.pairs]
    first = names.index(machine.valve.start or names[0])
    supply = machine.valve.supply
    state["state"] = state["last"] = first
    state["blend"], state["stroke"] = valve.joins[first], math.inf
    state["place"], state["pressure"] = -gap / units.length, 1.0 if supply is None else supply.start
    _begin(valve, state[0])
    with watched(progress) as watch:
        outcome, last, known = "", 0, 0
        while not outcome:
            while run.count["step"][0] < record.load.size:
                check_interrupted()
                follow_valve(record, valve, state, run.now, run.count, run._log, _AT_ONCE)
                run._empty()
            run.count["step"] = 0
            run.now["time"] += _TURN
            run.now["next_drag"] = 0.5 * record.drag.interval
            run.periods += 1
            done = int(run.count["blow"][0])
            last, known = (run.periods, done) if done != known else (last, known)
            if watch is not None and watch(Progress(done, run.time, min(done / number, 1.0))):
                outcome = "interrupted"
            elif done >= number:
                outcome = "impacts"
            elif most_time is not None and run.time / rate >= most_time:
                outcome = "time"
            elif run.periods - last >= _PATIENCE:
                outcome = "stalls"
    tool = (run.rock_work, run.advanced) if record.bit.fed else None
    impacts, _ = impacts_of(run.contacts, Load.harmonic(0.0, 0.0), machine.body.transit_time, tool)
    impacts = impacts.part(slice(0, max(0, impacts.size - bool(run.count["struck"][0]))))
    taken = float(state["taken"][0]) * units.energy
    return ValveWaves(machine, target, lattice, units, impacts, run.time / rate, outcome, taken)


def _valve(machine: Machine, asked: LatticeUnits, units: LatticeUnits) -> LatticeValve:
    """The valve in the units of the lattice; a machine in SI has the bar's mass and length, and the second."""
    own = machine.valve
    if any(port.reads != "centre" for port in own.ports):
        raise ParameterError("ports", "a place on the bar", 'ports that read the centre: reads = "centre"')
    bar = machine.bar
    assert bar is not None
    force, time = bar.mass * bar.length / units.force, units.rate
    scaled = own.scaled(force, 1.0, time)
    names, gas = [name for name, _ in own.pairs], own.supply and own.supply.gas
    if gas is not None and scaled.supply is not None and not scaled.supply.compliance > 0.0:
        raise ParameterError("supply.line", 0.0, "a volume of oil in the line, for when the accumulator is empty")
    law = OilMachine(replace(machine, valve=scaled), 0).law
    return LatticeValve(
        law.numbers, np.ascontiguousarray(law.joins[:, :CHAMBERS]), own.flows,
        np.array([names.index(port.to) for port in scaled.ports], np.int64),
        np.array([port.speed is not None for port in scaled.ports]),
        np.array([port.level for port in scaled.ports]),
        np.array([port.sign for port in scaled.ports]),
        np.array([port.delay for port in scaled.ports]),
    )  # fmt: skip


def _begin(valve: LatticeValve, state: np.void) -> None:
    """At the start, ports whose region is occupied demand at once, in their order."""
    for i in range(valve.to.size):
        reads = 0.0 if valve.speed[i] else float(state["place"])
        if valve.sign[i] * (reads - valve.level[i]) > 0.0 and valve.to[i] != state["last"]:
            due = float(valve.delay[i])
            kept = [n for n in range(int(state["orders"])) if state["due"][n] < due]
            state["due"][len(kept)], state["to"][len(kept)] = due, valve.to[i]
            state["orders"], state["last"] = len(kept) + 1, valve.to[i]
