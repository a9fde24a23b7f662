"""Blows that follow each other, each beginning with the waves that those before have left in the tool."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.blow.blow import Blow
from percuss.blow.bodies import Rod, rod_sections, striker_sections
from percuss.blow.drilling import bit_contacts, joint_turns, rest_penetration
from percuss.blow.figures import BlowOutcome, ContactInterval, Fineness
from percuss.blow.kernels.lattice_motion import struck_again
from percuss.blow.kernels.lattice_records import ELASTIC, LatticeMachine
from percuss.blow.periods.lattice import Lattice, LatticeUnits, train_record
from percuss.blow.periods.wave_motion import LatticeRun
from percuss.blow.striking import strike, strike_again
from percuss.errors import ConvergenceError, ParameterError
from percuss.halting import check_interrupted
from percuss.model import SizedBody
from percuss.model.checks import Array, callback, count, flag, instance, numbers, positive
from percuss.short_repr import ShortRepr, watched
from percuss.simulate import Progress

_TURN = 2.0 * math.pi
_GRAZE = 1e-9  # of the greatest impulse of a blow

# ---- One blow of many, with what became of its energy


@dataclass(frozen=True)
class BlowInTrain(ShortRepr):
    """A blow, from the touch of the striker to the next blow; in SI, times from its own start.

    Attributes
    ----------
    contacts, bit_contacts
        Of the faces, and of bit and rock: the first of these begins at 0 when the bit stands on the rock.
    energy_before, returned_energy, vibration_energy
        Of the striker; M V²/2 of its mean velocity after the blow, and what is ringing in it then.
    mean_velocity_after, impulse
        V, negative for a striker that goes back, and ∫ N dt of all contacts.
    tool_energy_before, tool_energy_after, energy_left
        Kinetic and strain energy of the tool with the bit, without joints; and E_left, that of what departs from the
        static state at the end.
    joint_energy
        Rise of the energy in the springs and masses of joints.
    feed_force_work, recoil_spring_work, recoil_damper_loss
        F ∫ v dt, −k_d ∫ y v dt and c_d ∫ v² dt while the feed acts; `feed_work` is ∫ Q v dt.
    steel_loss, joint_loss, energy_out
        Taken by attenuation (less than 0 where relaxed tension gives preload energy back) and by dashpots of joints,
        and what has left through the end of an endless rod.
    rock_work, rock_impulse, greatest_rock_force
        ∫ F v dt, ∫ F dt and the greatest F.
    penetration_before, penetration_after, greatest_penetration, residual_penetration
        Of the bit in this blow's rock; (1 − γ) u_m is what remains.
    rock_dissipated
        (1 − γ) K_1 (u_m² − u_m0²)/2.
    advance
        Penetration at rest under the feed after the blow, less that at its start.
    stands
        Whether the bit is on the rock when the next blow comes.
    tension, compression
        The greatest of each section of the tool at nine places of it, in N; shape (sections,).
    """

    contacts: tuple[ContactInterval, ...]
    bit_contacts: tuple[ContactInterval, ...]
    energy_before: float
    returned_energy: float
    vibration_energy: float
    mean_velocity_after: float
    impulse: float
    tool_energy_before: float
    tool_energy_after: float
    energy_left: float
    joint_energy: float
    feed_force_work: float
    recoil_spring_work: float
    recoil_damper_loss: float
    feed_impulse: float
    steel_loss: float
    joint_loss: float
    energy_out: float
    rock_work: float
    rock_impulse: float
    greatest_rock_force: float
    penetration_before: float
    penetration_after: float
    greatest_penetration: float
    residual_penetration: float
    rock_dissipated: float
    advance: float
    face_advance: float
    stands: bool
    tension: Array
    compression: Array

    @property
    def feed_work(self) -> float:
        """∫ Q v dt."""
        return self.feed_force_work + self.recoil_spring_work - self.recoil_damper_loss

    @property
    def energy_error(self) -> float:
        """By how much the balance of energy does not close, over the striker's energy: means over cells."""
        before = self.energy_before + self.tool_energy_before + self.feed_work
        striker = self.returned_energy + self.vibration_energy
        lost = self.steel_loss + self.joint_loss + self.energy_out
        after = striker + self.tool_energy_after + self.joint_energy + self.rock_work + lost
        return (before - after) / self.energy_before


_NUMBERS = (
    *(one.name for one in fields(BlowInTrain) if one.type in ("float", "bool")), "feed_work", "energy_error",
)  # fmt: skip


class _Ledger(NamedTuple):
    """What has been summed up to a moment, and what is in the tool then; dimensionless."""

    tool_energy: float
    departure: float
    on_the_way: float  # what steel takes of waves that have not arrived yet
    springs: float
    sums: dict[str, float]
    losses: float
    rock: float
    greatest: float
    penetration: float
    moved: float


_SUMS = ["force_work", "spring_work", "damper_loss", "feed_impulse", "steel_loss", "out", "rock_impulse"]


class _Tool:
    """Reads what is in a tool on the lattice."""

    def __init__(self, machine: LatticeMachine, way: Array) -> None:
        self.machine = machine
        self.ages = [np.exp(-a * (n - np.arange(n) - 0.5)) for a, n in zip(way, machine.rod.cells, strict=True)]

    def ledger(self, run: LatticeRun) -> _Ledger:
        machine, now = self.machine, run.now[0]
        rod, held, bit = machine.rod, machine.held, machine.bit
        total = departure = way = 0.0
        for i, (z, first, cells, slot) in enumerate(zip(rod.impedance, rod.first, rod.cells, rod.slot, strict=True)):
            static = 0.5 * held.preload[i] / z
            for wave, sign in ((rod.right, 1.0), (rod.left, -1.0)):
                raw = np.roll(wave[first : first + cells], -slot)
                left = self.ages[i] * raw
                departure += z * machine.step * float(left @ left)
                total += z * machine.step * float(np.sum((sign * static + left) ** 2))
                if self.ages[i][0] < 1.0:
                    lost = (raw - left) * (2.0 * sign * static + raw + left)
                    way += z * machine.step * float(np.sum(lost))
        joint, springs, own = held.joint, 0.0, 0.5 * bit.mass * float(now["bit_velocity"]) ** 2
        for i in range(held.kind.size):
            if held.kind[i] == ELASTIC:
                whole = float(joint["place"][i]) + held.preload[i] / held.spring[i]
                springs += 0.5 * held.spring[i] * whole**2
            springs += 0.5 * held.mass[i] * float(joint["velocity"][i]) ** 2
        sums = {name: float(held.tool[name][0]) for name in _SUMS}
        greatest, deep = float(now["greatest"]), float(now["penetration"])
        force = float(held.tool["rock_force"][0])
        rock = 0.0
        if bit.stiffness > 0.0:
            rock = 0.5 * bit.stiffness * (1.0 - bit.ratio) * greatest**2 + 0.5 * bit.ratio * force**2 / bit.stiffness
        place = float(now["moved"])
        losses = float(joint["loss"].sum())
        return _Ledger(total + own, departure + own, way, springs, sums, losses, rock, greatest, deep, place)


# ---- What many blows come to: a fixed point, a cycle of two, or nothing that repeats

_SETTLED = 1e-6  # of u_m: changes from blow to blow below which it has settled
_ROUNDING = 1e-9  # of u_m: changes below which nothing is read from them
_FEW = 4  # blows from which on a régime is looked for


@dataclass(frozen=True)
class Regime(ShortRepr):
    """What the greatest penetrations u_m of many blows say of where they go.

    Attributes
    ----------
    kind
        "fixed point", "2-cycle", "no periodic régime", or "too few blows".
    cycle
        How many blows make it up: 1, 2, or the later half of those that were followed.
    multiplier
        By which the distance from a fixed point shrinks in a blow, with its sign, from the changes of u_m; None where
        these are too small, or do not shrink.
    scatter
        (max − min)/mean of u_m in it.
    """

    kind: Literal["fixed point", "2-cycle", "no periodic régime", "too few blows"]
    cycle: int
    multiplier: float | None
    scatter: float


def regime_of(penetrations: Array) -> Regime:
    """That of a row of greatest penetrations."""
    u = np.asarray(penetrations, dtype=float)
    n, mean = u.size, float(np.abs(u).mean()) if u.size else 0.0
    if n < _FEW or mean == 0.0:
        return Regime("too few blows", n, None, _spread(u))
    change = np.diff(u)
    if abs(change[-1]) < _SETTLED * mean:
        return Regime("fixed point", 1, _multiplier(change / mean), _spread(u[-2:]))
    if np.abs(u[-2:] - u[-4:-2]).max() < _SETTLED * mean:
        return Regime("2-cycle", 2, None, _spread(u[-2:]))
    later = (n + 1) // 2
    return Regime("no periodic régime", later, None, _spread(u[-later:]))


def _spread(u: Array) -> float:
    return float((u.max() - u.min()) / u.mean()) if u.size and u.mean() else 0.0


def _multiplier(change: Array) -> float | None:
    """From the last three changes that are more than rounding: √(d_{n+2}/d_n), with the sign of their ratio."""
    above = np.flatnonzero(np.abs(change) <= _ROUNDING)
    known = change[: above[0]] if above.size else change
    if known.size < 3 or abs(known[-1]) >= abs(known[-3]):
        return None
    return math.copysign(math.sqrt(abs(known[-1] / known[-3])), known[-1] * known[-2])


@dataclass(frozen=True)
class RepeatedBlows(ShortRepr):
    """Blows that follow each other; in SI.

    Attributes
    ----------
    striker, target, velocity, period, blows_per_crater
        What was asked for; the rock is new after so many blows, 0 for never.
    blows
        All of them, in order.
    lattice
        On which waves travelled; None where they are exact but for rounding.
    openings
        Of each step of the tool: how often a contact joint has opened, when it first did and shut again, in s (None:
        never), and the widest gap.
    error
        How far the greatest penetrations on a lattice with half the cells are from these, relative;
        None where that was not asked for, and without a lattice.
    """

    striker: SizedBody
    target: Rod
    velocity: tuple[float, ...]
    period: float
    blows_per_crater: int
    blows: tuple[BlowInTrain, ...]
    lattice: Lattice | None
    openings: tuple[tuple[int, float | None, float | None, float], ...]
    error: float | None = None

    @cached_property
    def regime(self) -> Regime:
        """What they come to."""
        return regime_of(np.array([one.greatest_penetration for one in self.blows]))

    @property
    def settled(self) -> tuple[BlowInTrain, ...]:
        """The blows of the régime: one, two, or the later half."""
        return self.blows[-self.regime.cycle :]

    def mean(self, figure: str) -> float:
        """The mean of a number of a blow over the régime, by its name; ParameterError for another name."""
        if not isinstance(figure, str) or figure not in _NUMBERS:
            raise ParameterError("figure", figure, "the name of a number of a BlowInTrain, such as 'rock_work'")
        return float(np.mean([getattr(one, figure) for one in self.settled]))

    @property
    def mean_rock_force(self) -> float:
        """F̄ on the rock over the régime, in N."""
        return self.mean("rock_impulse") / self.period

    @property
    def static_penetration(self) -> float:
        """u_s = F/K_1 of fresh rock, in m; 0 without rock or feed."""
        rock, feed = self.target.rock, self.target.feed
        return 0.0 if rock is None or feed is None else feed.force / rock.stiffness

    @property
    def bound(self) -> float | None:
        """√(E_left/W_load), W_load = K_1 U²/2: the most by which waves left change a blow; None without rock."""
        rock = self.target.rock
        if rock is None:
            return None
        deep = self.mean("greatest_penetration") - self.static_penetration
        return math.sqrt(max(self.mean("energy_left"), 0.0) / (0.5 * rock.stiffness * deep**2)) if deep > 0.0 else None

    @property
    def stands(self) -> bool:
        """Whether the bit is on the rock at every blow of the régime."""
        return all(one.stands for one in self.settled)

    def __str__(self) -> str:
        return f"{len(self.blows)} blows: {self.regime.kind}; bit {'stands' if self.stands else 'off'} at a blow"


def strike_repeatedly(
    striker: SizedBody,
    target: Rod,
    velocity: Any,
    period: float,
    number: int = 60,
    *,
    blows_per_crater: int = 1,
    cells: int | None = None,
    estimate: bool = True,
    progress: Callable[[Progress], object] | None = None,
) -> RepeatedBlows:
    """Strike a tool again and again, each time with the waves and the bit as the blow before has left them.

    Blow n begins at n × `period`: a fresh striker, free of stress, touches the face there, and the old one is gone. The
    first finds the tool in its static state. Waves are exact, as `strike` and `strike_again` have them, as long as
    they have few pieces: with a damper, or where steel takes much. Others travel on a lattice of equal cells, where
    what a node does in a cell is in closed form (docs: What holds the tool): errors fall as the square of the cells,
    but for events between its points.

    Parameters
    ----------
    striker, target
        In SI; a rod with any end but a free one, with its feed, joints and attenuation.
    velocity
        Of the striker, or of each of its sections, in m/s.
    period, number
        Time between two blows in s, and how many there are.
    blows_per_crater
        After so many blows the rock is replaced at equal force on the bit; 0 keeps the crater.
    cells, estimate
        Cells of the striker, at least, on a lattice, and whether to tell the error from one with half as many. None:
        exact waves, or where they have too many pieces 400 cells.
    progress
        Called now and then with a `percuss.simulate.Progress`; the blows end when it returns something true.

    Raises
    ------
    ParameterError
        For a dimensionless striker, a wall, a free end, a period shorter than the way of a wave through the striker and
        back, and numbers out of range.
    Interrupted
        When a block of `percuss.halting` was told to stop.

    Examples
    --------
    >>> from percuss.blow import Feed, Rock, Rod
    >>> from percuss.model import Bar, Section
    >>> tool = Rod([Section(1.0, area=1e-3)], "rock", bit_mass=2.0, attenuation=0.06, rock=Rock(4e8, 0.1),
    ...            feed=Feed(12e3, damping=8e3))
    >>> train = strike_repeatedly(Bar(0.5, area=1e-3), tool, 10.0, 6e-3, 9, cells=100)
    >>> train.regime.kind, train.stands
    ('fixed point', True)
    """
    if not isinstance(striker, SizedBody):
        raise ParameterError("striker", striker, "a bar with its sizes: Bar or SectionedBar")
    instance("target", target, Rod)
    if target.impedance is not None or target.end == "free":
        remedy = 'for example end="rock" with its rock'
        raise ParameterError("target", target.end, "a rod of sections whose end holds it", remedy)
    own = striker_sections(striker)
    given = np.atleast_1d(numbers("velocity", velocity))
    if given.ndim != 1 or given.size not in (1, own.impedance.size):
        raise ParameterError("velocity", velocity, f"a number, or one for each of {own.impedance.size} sections")
    speeds = np.broadcast_to(given, own.impedance.shape)
    period, number = positive("period", period), count("number", number, 1, 100_000)
    if period < 2.0 * float(own.transit.sum()):
        wanted = f"a time of at least {2.0 * float(own.transit.sum()):.3g} s, in which a wave runs through the striker"
        raise ParameterError("period", period, wanted + " and back")
    same = count("blows_per_crater", blows_per_crater, 0, 100_000)
    number_of_cells = _CELLS if cells is None else count("cells", cells, least=16, most=100_000)
    flag("estimate", estimate)
    callback("progress", progress)

    def followed(cells: int) -> RepeatedBlows:
        with watched(progress) as watch:
            return _followed(striker, target, speeds, period, number, same, cells, watch)

    if cells is None:
        with watched(progress) as watch:
            exact = _exactly(striker, target, speeds, period, number, same, watch)
        if exact is not None:
            return exact
    found = followed(number_of_cells)
    if not estimate:
        return found
    one, other = (
        np.array([blow.greatest_penetration for blow in each.blows])
        for each in (found, followed(max(8, number_of_cells // 2)))
    )
    n = min(one.size, other.size)
    apart = float(np.abs(one[:n] - other[:n]).max(initial=0.0))
    return replace(found, error=apart / float(np.abs(one).max()) if one.any() else 0.0)


_CELLS = 400  # of the striker, where waves have too many pieces
_MOST_PIECES = 1_500_000  # of all blows: a few seconds
_PLACES = 256  # of a window, at which the gap of a joint is looked at


def _exactly(
    striker: SizedBody, target: Rod, speeds: Array, period: float, number: int, same: int,
    progress: Callable[[Progress], object] | None,
) -> RepeatedBlows | None:  # fmt: skip
    """The blows by exact waves; None as soon as these can be seen to have too many pieces."""
    blows, openings, pieces, one = list[BlowInTrain](), _Openings(target), 0, None
    for n in range(number):
        most = _MOST_PIECES - pieces
        try:
            if one is None:
                one = strike(striker, replace(target, gap=0.0), speeds, until=period, most_pieces=most)
            else:
                one = strike_again(one, new_rock=same > 0 and n % same == 0, most_pieces=most)
        except (ParameterError, ConvergenceError):
            return None
        own = int(one._course.held.waves.pieces.sum())
        pieces += own
        cut = one.fineness is not Fineness.EXACT or one.outcome is BlowOutcome.TOO_MANY_PIECES
        if cut or pieces + own * (number - 1 - n) > _MOST_PIECES:
            return None
        blows.append(_exact_blow(one))
        openings.add(one, n * period)
        if progress is not None and progress(Progress(n + 1, (n + 1) * _TURN, (n + 1) / number)):
            break
    return RepeatedBlows(
        striker, target, tuple(speeds.tolist()), period, same, tuple(blows), None, tuple(openings.told)
    )


class _Openings:
    """Of each step: how often it has opened, when it first did and shut again, and the widest gap."""

    def __init__(self, target: Rod) -> None:
        steps = len(target.sections) - 1
        self.told: list[tuple[int, float | None, float | None, float]] = [(0, None, None, 0.0)] * steps
        self.apart = [0.0] * steps

    def add(self, blow: Blow, begun: float) -> None:
        course = blow._course
        ticks = [course.end * i // _PLACES for i in range(_PLACES + 1)]
        for at, opens, closes in joint_turns(blow):
            number, first, shut, widest = self.told[at - 1]
            first = begun + opens[0] if opens and first is None else first
            later = [begun + time for time in closes if first is not None and begun + time > first]
            shut = later[0] if later and shut is None else shut
            node = course.striker + at
            if opens or self.apart[at - 1] > 0.0:
                for since, until in pairwise(ticks):
                    moved = course.travelled(node, since, until) - course.sums(2 * node - 1, since, until).plain
                    self.apart[at - 1] += moved - course.arrived(2 * node - 2, since, until).plain
                    widest = max(widest, self.apart[at - 1] * course.scales.length)
            self.told[at - 1] = number + len(opens), first, shut, widest


_ALIKE = (
    "energy_before mean_velocity_after impulse tool_energy_before tool_energy_after feed_force_work recoil_spring_work "
    "recoil_damper_loss feed_impulse steel_loss joint_loss rock_work rock_impulse rock_dissipated face_advance"
)
"""Figures that have the same name of a `Blow`."""


def _exact_blow(blow: Blow) -> BlowInTrain:
    """What a blow by exact waves has done, in SI."""
    course, rod = blow._course, blow._course.held.rod
    assert rod is not None and rod.area is not None
    before, deepest, force = blow.penetration_before or 0.0, blow.greatest_penetration or 0.0, 0.0
    if blow.penetration is not None:
        force = course.value(2 * course.size + 2, course.end)
        if course.held.struck_before:
            before = course.value(2 * course.size + 1, 0) * course.scales.length
    peaks, bit = blow.peaks[course.striker :], bit_contacts(blow)
    least = _GRAZE * max((one.impulse for one in blow.contacts), default=0.0)
    same: dict[str, Any] = {name: getattr(blow, name) for name in _ALIKE.split()}
    return BlowInTrain(
        **same,
        contacts=tuple(one for one in blow.contacts if one.impulse > least),
        bit_contacts=bit,
        returned_energy=blow.rigid_energy_after,
        vibration_energy=blow.vibration_energy_after,
        energy_left=blow.tool_dynamic_energy + blow.bit_kinetic_energy_after,
        joint_energy=blow.joint_energy_change,
        energy_out=blow.energy_out_of_the_end,
        greatest_rock_force=max((one.peak_force for one in bit), default=0.0),
        penetration_before=before,
        penetration_after=blow.penetration_after or 0.0,
        greatest_penetration=deepest,
        residual_penetration=blow.residual_penetration or 0.0,
        advance=(rest_penetration(blow, deepest) or 0.0) - before,
        stands=force > 0.0,
        tension=np.array([one.tension for one in peaks]) * rod.area,
        compression=np.array([one.compression for one in peaks]) * rod.area,
    )


def _followed(
    striker: SizedBody, target: Rod, speeds: Array, period: float, number: int, same: int, cells: int,
    progress: Callable[[Progress], object] | None,
) -> RepeatedBlows:  # fmt: skip
    own, rod = striker_sections(striker), rod_sections(target, striker)
    mass = float(own.impedance @ own.transit)
    speed = float(speeds @ (own.impedance * own.transit)) / mass or 1.0
    rate = _TURN / period
    lattice, machine, units = train_record(own, target, rod, LatticeUnits(mass, rate, abs(speed) / rate), cells)
    run = LatticeRun(machine, 0.0)
    lengths = np.where(np.isfinite(rod.length), rod.length, 0.0)
    tool = _Tool(machine, np.asarray(target.attenuation) * lengths / machine.rod.cells)
    velocity, blows = speeds / (units.rate * units.length), list[BlowInTrain]()
    for n in range(number):
        check_interrupted()
        struck_again(machine, run.now, run.count, velocity, n > 0 and same > 0 and n % same == 0)
        before, energy, begun = tool.ledger(run), run.energy, run.time
        for _ in run.period():
            check_interrupted()
        blows.append(_told(run, before, tool.ledger(run), energy, begun, units, target))
        if progress is not None and progress(Progress(n + 1, run.time, (n + 1) / number)):
            break
    return RepeatedBlows(
        striker, target, tuple(speeds.tolist()), period, same, tuple(blows), lattice, _openings(run, units)
    )


def _openings(run: LatticeRun, units: LatticeUnits) -> tuple[tuple[int, float | None, float | None, float], ...]:
    def moment(value: float) -> float | None:
        return value / units.rate if value >= 0.0 else None

    return tuple(
        (int(one["openings"]), moment(one["opened"]), moment(one["closed"]), float(one["widest"]) * units.length)
        for one in run.machine.held.joint
    )


def _intervals(log: npt.NDArray[np.void], begun: float, units: LatticeUnits) -> tuple[ContactInterval, ...]:
    least, impulse = _GRAZE * log["impulse"].max(initial=0.0), units.force / units.rate
    return tuple(
        ContactInterval(
            (one["start"] - begun) / units.rate,
            None if math.isnan(one["end"]) else (one["end"] - begun) / units.rate,
            float(one["impulse"]) * impulse,
            float(one["peak"]) * units.force,
        )
        for one in log
        if one["impulse"] > least
    )


def _told(
    run: LatticeRun, before: _Ledger, after: _Ledger, energy: float, begun: float, units: LatticeUnits, target: Rod
) -> BlowInTrain:
    """What a blow has done, in SI."""
    machine, held = run.machine, run.machine.held
    e, length, impulse = units.energy, units.length, units.force / units.rate
    grown = {name: after.sums[name] - before.sums[name] for name in _SUMS}
    momentum = float(run.now["momentum"][0])
    contacts = run.taken()
    if run.touching and contacts.size:
        contacts["end"][-1] = math.nan
    kept = 1.0 - machine.bit.ratio
    deepest = after.greatest * length
    feed = 0.0 if target.feed is None or target.rock is None else target.feed.force / target.rock.stiffness
    rest = kept * deepest + machine.bit.ratio * feed
    moved = after.penetration * length
    stiffness = 0.0 if target.rock is None else target.rock.stiffness
    return BlowInTrain(
        contacts=_intervals(contacts, begun, units),
        bit_contacts=_intervals(held.bit_log[: int(held.tool["bit_contacts"][0])], begun, units),
        energy_before=energy * e,
        returned_energy=0.5 * momentum**2 * e,
        vibration_energy=(run.energy - 0.5 * momentum**2) * e,
        mean_velocity_after=momentum * units.rate * length,
        impulse=float(contacts["impulse"].sum()) * impulse,
        tool_energy_before=before.tool_energy * e,
        tool_energy_after=after.tool_energy * e,
        energy_left=after.departure * e,
        joint_energy=(after.springs - before.springs) * e,
        feed_force_work=grown["force_work"] * e,
        recoil_spring_work=grown["spring_work"] * e,
        recoil_damper_loss=grown["damper_loss"] * e,
        feed_impulse=grown["feed_impulse"] * impulse,
        steel_loss=(grown["steel_loss"] + after.on_the_way - before.on_the_way) * e,
        joint_loss=(after.losses - before.losses) * e,
        energy_out=grown["out"] * e,
        rock_work=(after.rock - before.rock) * e,
        rock_impulse=grown["rock_impulse"] * impulse,
        greatest_rock_force=float(held.tool["rock_peak"][0]) * units.force,
        penetration_before=before.penetration * length,
        penetration_after=moved,
        greatest_penetration=deepest,
        residual_penetration=kept * deepest,
        rock_dissipated=0.5 * kept * stiffness * (after.greatest**2 - before.greatest**2) * length**2,
        advance=rest - before.penetration * length,
        face_advance=(after.moved - before.moved) * length,
        stands=bool(held.tool["rock_force"][0] > 0.0),
        tension=np.maximum(-held.extreme[:, 0], 0.0) * units.force,
        compression=np.maximum(held.extreme[:, 1], 0.0) * units.force,
    )
