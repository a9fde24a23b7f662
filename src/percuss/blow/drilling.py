"""Blows that drill: what a blow is worth in advance, and what of its energy goes where."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from percuss.blow.blow import Blow
from percuss.blow.bodies import Rod
from percuss.blow.figures import ContactInterval
from percuss.blow.kernels.wave_records import CONTACT, ELASTIC
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.checks import finite, instance, positive

# ---- How far the hole gets with a blow: by the crater that it leaves, or by the work that the rock takes per volume


@dataclass(frozen=True)
class Drilling:
    """A bit and what of its penetration, or of the work that it does, is advance of the hole.

    Parameters
    ----------
    bit_diameter
        Of the hole, in m.
    crater_factor
        Advance over the residual penetration: buttons leave rock between their craters.
    specific_energy
        Work that stays in the rock per volume drilled, in J/m³, as measured; instead of `crater_factor`.

    Examples
    --------
    >>> f"{Drilling(0.064, specific_energy=220e6).area:.6f}"
    '0.003217'
    """

    bit_diameter: float
    crater_factor: float | None = None
    specific_energy: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "bit_diameter", positive("bit_diameter", self.bit_diameter))
        for name in ("crater_factor", "specific_energy"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, positive(name, value))
        if (self.crater_factor is None) == (self.specific_energy is None):
            accepted = "either a crater_factor or a specific_energy"
            raise ParameterError("crater_factor", self.crater_factor, accepted, "a measured specific energy is better")

    @property
    def area(self) -> float:
        """Cross-section of the hole, in m²."""
        return 0.25 * math.pi * self.bit_diameter**2

    def advance(self, residual: float, dissipated: float) -> float:
        """Of the hole, in m, by a blow that leaves a penetration, in m, and dissipates work in the rock, in J."""
        residual, dissipated = finite("residual", residual), finite("dissipated", dissipated)
        if self.specific_energy is not None:
            return dissipated / (self.area * self.specific_energy)
        assert self.crater_factor is not None
        return self.crater_factor * residual


# ---- What a blow leaves behind: when the bit stood on the rock, when joints opened, what the next blow finds

_NOTHING = 1e-12  # share of the greatest impulse of all contacts that is rounding


def bit_contacts(blow: Blow) -> tuple[ContactInterval, ...]:
    """When the bit pressed on the rock, as a `ContactInterval` each; the first from 0 on where the tool is fed."""
    force = instance("blow", blow, Blow).bit_force
    if force is None:
        return ()
    presses = np.append(np.append(0, (force.coefficients != 0.0).any(axis=1)), 0)
    found = []
    for first, last in zip(np.flatnonzero(np.diff(presses) > 0), np.flatnonzero(np.diff(presses) < 0), strict=True):
        end = None if last == len(force.coefficients) else float(force.times[last])
        impulse, peak = force.piece_integrals[first:last].sum(), force.piece_peaks[first:last].max()
        found.append(ContactInterval(float(force.times[first]), end, float(impulse), float(peak)))
    least = _NOTHING * max((one.impulse for one in found), default=0.0)
    return tuple(one for one in found if one.impulse > least)


class JointTurns(NamedTuple):
    """A joint of the kind "contact": its step, and when its faces parted and met again, or its thread caught them."""

    at: int
    opens: tuple[float, ...]
    closes: tuple[float, ...]


def joint_turns(blow: Blow) -> tuple[JointTurns, ...]:
    """What the joints that open do in a blow; one that bears no force before it begins to open when that does."""
    course = instance("blow", blow, Blow)._course
    problem, unit = course.held.problem, course.scales.time * course.tick
    found = []
    for node in np.flatnonzero(problem.kind == CONTACT).tolist():
        times = [unit * tick for tick in course.turns_of(int(problem.traced[node]))]
        found.append(JointTurns(node - course.striker, tuple(times[1::2]), tuple(times[2::2])))
    return tuple(found)


def rest_penetration(blow: Blow, greatest: float) -> float | None:
    """Where the bit stands under the feed in a crater of this greatest penetration; None without rock."""
    rod = blow.target
    if not isinstance(rod, Rod) or rod.rock is None:
        return None
    force, rock = 0.0 if rod.feed is None else rod.feed.force, rod.rock
    loaded = force / rock.stiffness
    return loaded if greatest <= loaded else (1.0 - rock.unloading_ratio) * greatest + rock.unloading_ratio * loaded


@dataclass(frozen=True, eq=False)
class BlowsOneByOne:
    """Blows on one tool, each from its static state.

    Attributes
    ----------
    blows
        Those that differ: one in new rock, else those of one crater in turn.
    number
        How many there are in all.
    crater
        "new" rock for each, or the "same" crater.
    rate
        Blows in a second; None if unknown.
    drilling
        What they are worth in advance; None if unknown.
    machine_force
        The feed force on the machine, in N, where that is given; the tool has less.
    """

    blows: tuple[Blow, ...]
    number: int = 1
    crater: Literal["new", "same"] = "new"
    rate: float | None = None
    drilling: Drilling | None = None
    machine_force: float | None = None

    @property
    def first(self) -> Blow:
        """The first blow."""
        return self.blows[0]

    @property
    def feed_force(self) -> float | None:
        """On the tool, in N; None without a feed."""
        feed = self.first.target.feed if isinstance(self.first.target, Rod) else None
        return None if feed is None else feed.force

    # -- what the next blow finds --

    @cached_property
    def backward_momentum(self) -> float:
        """The greatest with which the tool left the rock in the first blow; 0 if it did not leave."""
        course, greatest = self.first._course, 0.0
        for one in bit_contacts(self.first):
            if one.end is None:
                continue
            tick = min(round(one.end / (course.scales.time * course.tick)), course.end)
            known = course.size - 1 if course.endless(course.size - 1) else course.size
            momentum = course.momentum(course.striker, known, tick) + sum(course.lumped_momentum(tick))
            greatest = max(greatest, -momentum * course.scales.momentum)
        return greatest

    @property
    def least_feed(self) -> float | None:
        """2 f P_r: the feed force under which a tool of this backward momentum is back before the next blow."""
        return None if self.rate is None else 2.0 * self.rate * self.backward_momentum

    @property
    def stands(self) -> bool | None:
        """Whether the bit stands on the rock when the next blow comes; None without a rate, a feed or rock."""
        if self.least_feed is None or self.feed_force is None or self.first.penetration is None:
            return None
        return self.feed_force > self.least_feed

    @cached_property
    def energy_left(self) -> float:
        """A bound of what departs from the static state when the next blow comes, or at the end of the window."""
        # d‖x‖²/dt <= −2 a E' as long as nothing switches: only waves fall, all of them as fast as the slowest at least
        blow, course = self.first, self.first._course
        rod = range(course.striker, course.size)
        rest = 0.0 if self.rate is None else max(0.0, 1.0 / self.rate - blow.until)
        slowest = min((course.rate[i] for i in rod if not course.endless(i)), default=0.0) / course.scales.time
        waves = blow.tool_dynamic_energy * math.exp(-2.0 * slowest * rest)
        return waves + blow.bit_kinetic_energy_after + self._stored_after

    @property
    def _stored_after(self) -> float:
        """Of masses at joints, of springs of joints and of the rock, all above the static state."""
        course, problem = self.first._course, self.first._course.held.problem
        end = course.end
        found = sum(0.5 * mass * float(speed[0]) ** 2 for mass, speed in course.lumped_masses([end])[:-1])
        for node in np.flatnonzero(problem.kind == ELASTIC).tolist():
            found += 0.5 * float(problem.spring[node]) * course.value(int(problem.traced[node]) + 1, end) ** 2
        if self.first.penetration is not None:
            force = course.value(2 * course.size + 2, end) - course.preload(course.size - 1)
            found += 0.5 * force**2 / problem.unloading
        return found * course.scales.energy

    @property
    def left_bound(self) -> float | None:
        """√(E_left/W_load): by which share what is left may change the penetration of the next blow; None without rock.

        W_load = K_1 U²/2 with the penetration U that the blow adds (Cauchy–Schwarz, in rock that is loaded once).
        """
        blow = self.first
        if not isinstance(blow.target, Rod) or blow.target.rock is None or blow.greatest_penetration is None:
            return None
        added = blow.greatest_penetration - (self.feed_force or 0.0) / blow.target.rock.stiffness
        load = 0.5 * blow.target.rock.stiffness * added**2
        return math.sqrt(self.energy_left / load) if load > 0.0 else None

    # -- forces in the mean, advance --

    @property
    def recoil_force(self) -> float | None:
        """f J: with what the blows push the machine back in the mean; None without a rate."""
        return None if self.rate is None else self.rate * sum(blow.impulse for blow in self.blows) / len(self.blows)

    @property
    def mean_rock_force(self) -> float | None:
        """f J + F, on the rock in the mean of blows in a bounded motion: the force on the machine."""
        if self.recoil_force is None or self.feed_force is None or self.first.penetration is None:
            return None
        return self.recoil_force + self.feed_force

    @property
    def rock_dissipated(self) -> float:
        """What stays in the rock of the blows, in the mean."""
        return sum(blow.rock_dissipated for blow in self.blows) / len(self.blows)

    @property
    def advance_per_blow(self) -> float | None:
        """By the crater factor, or by the specific energy; None without either."""
        own = self.drilling
        if own is None:
            return None
        return own.advance((self.blows[-1].residual_penetration or 0.0) / len(self.blows), self.rock_dissipated)

    @property
    def rate_of_penetration(self) -> float | None:
        """In m/s; None without a rate, or an advance."""
        return None if self.advance_per_blow is None or self.rate is None else self.rate * self.advance_per_blow

    @property
    def specific_energy_rock(self) -> float | None:
        """What stays in the rock per volume drilled, J/m³."""
        return self._per_volume(self.rock_dissipated)

    @property
    def specific_energy_blow(self) -> float | None:
        """Energy of the striker per volume drilled, J/m³."""
        return self._per_volume(sum(blow.energy_before for blow in self.blows) / len(self.blows))

    def _per_volume(self, energy: float) -> float | None:
        volume = 0.0 if self.drilling is None else (self.advance_per_blow or 0.0) * self.drilling.area
        return energy / volume if volume > 0.0 else None


# ---- Blows one by one, and the feed that a machine leaves for its tool

_AGREE = 1e-12  # of the force on the machine
_MOST_TURNS = 60


def blows_one_by_one(
    blow_of: Callable[[Rod, float], Blow],
    rod: Rod,
    *,
    number: int = 1,
    crater: Literal["new", "same"] = "new",
    blows_per_crater: int = 1,
    rate: float | None = None,
    drilling: Drilling | None = None,
    of_machine: bool = False,
) -> BlowsOneByOne:
    """So many blows, each from the static state of the tool.

    Parameters
    ----------
    blow_of
        The blow on a rod whose crater has a greatest penetration, in m; 0 in new rock.
    rod
        The tool, with rock where `crater` is "same".
    number, crater, blows_per_crater, rate, drilling
        As `BlowsOneByOne` has them; blows that differ are those of one crater.
    of_machine
        Whether the feed force of the rod acts on the machine: then the tool has F − f J(F).

    Raises
    ------
    ParameterError
        For a machine whose blows push it back with more than its feed force, or without a rate.
    """
    force = None
    if of_machine and rod.feed is not None:
        force, rod = rod.feed.force, _fed_by_machine(blow_of, rod, rate)
    blows = [blow_of(rod, 0.0)]
    for _ in range(1, min(number, blows_per_crater) if crater == "same" else 1):
        blows.append(blow_of(rod, blows[-1].greatest_penetration or 0.0))
    return BlowsOneByOne(tuple(blows), number, crater, rate, drilling, force)


def _fed_by_machine(blow_of: Callable[[Rod, float], Blow], rod: Rod, rate: float | None) -> Rod:
    """The rod under F − f J(F), by secants: f dJ/dF is some hundredths."""
    assert rod.feed is not None
    if rate is None:
        raise ParameterError("rate", None, "a rate of the blows, with a feed force on the machine")
    force, before = rod.feed.force, None
    now = max(0.0, force - rate * blow_of(rod, 0.0).impulse)
    for _ in range(_MOST_TURNS):
        tried = replace(rod, feed=replace(rod.feed, force=now))
        recoil = rate * blow_of(tried, 0.0).impulse
        rest = force - recoil - now
        if now == 0.0 and rest < 0.0:
            remedy = f"at least {recoil:.4g} N, or fewer blows in a second"
            wanted = f"a force on the machine above rate × impulse, {recoil:.4g} N, which pushes it back"
            raise ParameterError("force", force, wanted, remedy)
        if abs(rest) <= _AGREE * force:
            return tried
        slope = -1.0 if before is None or now == before[0] else (rest - before[1]) / (now - before[0])
        before, now = (now, rest), max(0.0, now - rest / (slope if slope < -0.2 else -1.0))
    raise ConvergenceError("the feed force that the machine leaves for its tool jumps", "give the force on the tool")
