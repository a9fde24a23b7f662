"""One blow: contacts, forces, energies, stresses, each computed from the waves when it is asked for."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from percuss.blow.bodies import Sections, Striker, Target
from percuss.blow.gauges import GaugeWaves, first_pulse
from percuss.blow.kernels.wave_records import ROCK
from percuss.blow.parts import BlowOutcome, ContactInterval, Peak, Pulse
from percuss.blow.question import Question, Scales
from percuss.blow.stresses import AlongBody, Extreme, StringState, along, force_extremes
from percuss.blow.wave_history import Trace, WaveHistory, centroid, contacts, gap
from percuss.errors import ParameterError
from percuss.model.checks import Array, finite, non_negative

# ---- Where the energy and the momentum of a blow are at its end, and how well both close


@dataclass(frozen=True)
class RockState:
    """Penetrations, and the work that the rock has taken."""

    greatest: float
    residual: float
    after: float
    force: float
    work: float
    dissipated: float


@dataclass(frozen=True)
class Balance:
    """Energies and momenta at the end of the window, in the scales of the blow."""

    energy_before: float
    momentum_before: float
    momentum_after: float
    load_impulse: float
    load_work: float
    impulse: float
    rigid_after: float
    vibration_after: float
    through_face: float
    rod_energy: float
    rod_momentum: float
    bit_energy: float
    momentum_error: float
    energy_error: float


def balance(course: WaveHistory, rock: RockState | None) -> Balance:
    """The balance of a blow.

    Striker and rod are summed from the waves in them, the work through the face from those that passed it, and the
    rock's from its law: the two errors compare what has been computed in different ways.
    """
    striker, size, end = course.striker, course.size, course.end
    before, momentum = course.energy(0, striker, 0), course.momentum(0, striker, 0)
    after, left = course.energy(0, striker, end), course.momentum(0, striker, end)
    impulse = course.sums(2 * size, 0, end).plain
    load_impulse, load_work = _load(course)
    rigid = 0.5 * left * left / course.mass
    through, rod, rod_momentum, lumped, bit = 0.0, 0.0, 0.0, 0.0, 0.0
    if course.has_rod:
        # ∫ N v dt of the rod's face: the power of a wave is Z f² − Z g²
        row, back = 2 * striker, course.transit[striker]
        returned = 0.0 if course.endless(striker) else course.sums(row + 1, -back, end - back).square
        through = float(course.impedance[striker]) * (course.sums(row, 0, end).square - returned)
        rod, rod_momentum = course.energy(striker, size, end), course.momentum(striker, size, end)
        joints, bits = course.lumped_energy([end])
        lumped, bit = float(joints[0]), float(bits[0])
    taken = 0.0 if rock is None else rock.work
    scale = max(before, abs(load_work), abs(through), 1e-300)
    errors = before + load_work - after - through, through - rod - lumped - bit - taken
    push = max(abs(momentum), abs(impulse), abs(load_impulse), (course.mass * before) ** 0.5, 1e-300)
    return Balance(
        energy_before=before,
        momentum_before=momentum,
        momentum_after=left,
        load_impulse=load_impulse,
        load_work=load_work,
        impulse=impulse,
        rigid_after=rigid,
        vibration_after=max(0.0, after - rigid),
        through_face=through,
        rod_energy=rod + lumped,
        rod_momentum=rod_momentum,
        bit_energy=bit,
        momentum_error=abs(momentum + load_impulse - left - impulse) / push,
        energy_error=max(map(abs, errors)) / scale,
    )


def _load(course: WaveHistory) -> tuple[float, float]:
    """Impulse and work of the load."""
    problem, impulse, work = course.held.problem, 0.0, 0.0
    ends = [*(int(t) for t in problem.load_start[1:]), course.end]
    for start, stop, force in zip(problem.load_start, ends, problem.load_force, strict=False):
        begin, end = int(start), min(int(stop), course.end)
        if end > begin:
            impulse += float(force) * (end - begin) * course.tick
            work += float(force) * course.travelled(problem.load_node, begin, end)
    return impulse, work


def rock_state(course: WaveHistory) -> RockState | None:
    """What the bit has done to the rock; None without one."""
    problem = course.held.problem
    if problem.end != ROCK:
        return None
    if course.held.state.time[course.size] == course.end:
        greatest = float(course.held.state.now[0].greatest)
    else:  # the bit has been followed beyond the window
        trace = course.trace(2 * course.size + 1)
        greatest = max(0.0, float(trace.before(trace.times[1:]).max()))
    force = course.value(2 * course.size + 2, course.end)
    dissipated = 0.5 * (1.0 - problem.ratio) * problem.stiffness * greatest**2
    stored = 0.5 * force**2 / problem.unloading
    return RockState(
        greatest=greatest,
        residual=(1.0 - problem.ratio) * greatest,
        after=course.value(2 * course.size + 1, course.end),
        force=force,
        work=dissipated + stored,
        dissipated=dissipated,
    )


# ---- One blow: contacts, forces, energies, stresses, each computed from the waves when it is asked for


@dataclass(frozen=True, eq=False)
class Blow:
    """One blow, from the first instant of its window to `until`; made by `strike`.

    Forces in N, times in s, energies in J where the striker has sizes. Of a dimensionless striker everything is in
    the scales mass 1, length 1, angular frequency 1. Velocities are positive toward the target, forces are positive
    in compression.

    Parameters
    ----------
    striker, target
        What struck, and what was struck.
    velocity
        Of each section before the blow, shape (K,); None where a field was given.
    until
        End of the window.
    outcome
        How it ended.
    """

    striker: Striker
    target: Target
    velocity: Array | None
    until: float
    outcome: BlowOutcome
    _question: Question = field(repr=False)
    _course: WaveHistory = field(repr=False)

    # -- contact --

    @cached_property
    def face_force(self) -> Trace:
        """The force between the faces."""
        return self._scaled(self._course.trace(2 * self._course.size), self._scales.force)

    @cached_property
    def _contacts(self) -> tuple[tuple[ContactInterval, ...], int]:
        found, grazes = contacts(self._course, self._course.trace(2 * self._course.size))
        time, scales = self._scales.time, self._scales
        return tuple(
            ContactInterval(
                time * one.start,
                None if one.end is None else time * one.end,
                scales.momentum * one.impulse,
                self._scales.force * one.peak_force,
            )
            for one in found
        ), grazes

    @property
    def contacts(self) -> tuple[ContactInterval, ...]:
        """The contacts, in turn."""
        return self._contacts[0]

    @property
    def grazes(self) -> int:
        """Touches without an impulse, left out of `contacts`."""
        return self._contacts[1]

    @property
    def contact_duration(self) -> float | None:
        """t_c, from the start of the first contact to the end of the last; None without such an end."""
        if not self.contacts or self.contacts[-1].end is None:
            return None
        return self.contacts[-1].end - self.contacts[0].start

    @property
    def force_centroid(self) -> float | None:
        """t_J, ∫ N t dt/∫ N dt of all contacts, from the start of the first."""
        return centroid(self.face_force) - self.contacts[0].start if self.contacts else None

    @property
    def impulse(self) -> float:
        """∫ N dt over the window."""
        return self._balance.impulse * self._scales.momentum

    # -- velocities of the striker as a whole --

    @cached_property
    def striker_mass(self) -> float:
        """Mass of the striker."""
        return float(np.dot(self._question.sections.impedance, self._question.sections.transit))

    @property
    def mean_velocity_before(self) -> float:
        """V_0, momentum over mass."""
        return self._balance.momentum_before / self._course.mass * self._scales.velocity

    @property
    def mean_velocity_after(self) -> float:
        """V_1, likewise at the end of the window."""
        return self._balance.momentum_after / self._course.mass * self._scales.velocity

    @property
    def striker_momentum_after(self) -> float:
        """M V_1."""
        return self._balance.momentum_after * self._scales.momentum

    @property
    def effective_restitution(self) -> float | None:
        """R_eff = −V_1/V_0; None for a striker without momentum before."""
        before = self._balance.momentum_before
        return 0.0 - self._balance.momentum_after / before if before != 0.0 else None

    @property
    def restitution_from_impulse(self) -> float | None:
        """J/(M V_0) − 1: R_eff without a load, and with one what B77's law makes of this impulse."""
        before = self._balance.momentum_before
        return self._balance.impulse / before - 1.0 if before != 0.0 else None

    @property
    def gap_after(self) -> float:
        """Distance between the faces."""
        return 0.0 if self._course.in_contact else gap(self._course) * self._scales.length

    # -- energies --

    @cached_property
    def _balance(self) -> Balance:
        return balance(self._course, self._rock)

    @cached_property
    def _rock(self) -> RockState | None:
        return rock_state(self._course)

    @property
    def energy_before(self) -> float:
        """Kinetic and strain energy of the striker before the blow."""
        return self._balance.energy_before * self._scales.energy

    @cached_property
    def kinetic_energy_before(self) -> float:
        """Of the striker."""
        if self.velocity is not None:
            mass = self._question.sections.impedance * self._question.sections.transit
            return float(0.5 * np.sum(mass * self.velocity**2))
        found = 0.0
        for i in range(self._course.striker):
            back = self._course.transit[i]
            right = self._course.trace(2 * i, 0, -back, 0)
            turned = Trace(-right.times[::-1] - back * self._course.tick, _mirrored(right.coefficients))
            left = self._course.trace(2 * i + 1, 0, -back, 0)
            found += float(self._course.impedance[i]) * turned.product_integral(left)
        return 0.5 * self.energy_before + found * self._scales.energy

    @property
    def load_work(self) -> float:
        """Work of the load."""
        return self._balance.load_work * self._scales.energy

    @property
    def rigid_energy_after(self) -> float:
        """M V_1²/2: given back to the machine where the striker rebounds."""
        return self._balance.rigid_after * self._scales.energy

    @property
    def vibration_energy_after(self) -> float:
        """The ringing of the striker."""
        return self._balance.vibration_after * self._scales.energy

    @property
    def work_through_face(self) -> float:
        """∫ N v dt of the rod's face: what rod, bit and rock have got."""
        return self._balance.through_face * self._scales.energy

    @property
    def rod_energy(self) -> float:
        """Kinetic and strain energy of the rod after the blow, with masses at its joints; what an endless one took."""
        return self._balance.rod_energy * self._scales.energy

    @property
    def rod_momentum(self) -> float:
        """Momentum of the rod after the blow."""
        return self._balance.rod_momentum * self._scales.momentum

    @property
    def bit_kinetic_energy_after(self) -> float:
        """Of the mass lumped at the far end."""
        return self._balance.bit_energy * self._scales.energy

    @property
    def momentum_error(self) -> float:
        """By how much momentum does not close, relative."""
        return self._balance.momentum_error

    @property
    def energy_error(self) -> float:
        """By how much energy does not close, in striker or rod, relative to what there was of it."""
        return self._balance.energy_error

    # -- rock --

    @property
    def rock_work(self) -> float:
        """Work done on the rock; 0 without one."""
        return 0.0 if self._rock is None else self._rock.work * self._scales.energy

    @property
    def rock_dissipated(self) -> float:
        """What of it is not given back, (1 − γ) K_1 u_m²/2 (Lundberg 1973)."""
        return 0.0 if self._rock is None else self._rock.dissipated * self._scales.energy

    @property
    def rock_stored(self) -> float:
        """What of it the rock could still give back."""
        return self.rock_work - self.rock_dissipated

    @property
    def efficiency(self) -> float | None:
        """η_1, work on the rock over the energy before; None without rock or energy."""
        before = self.energy_before
        return self.rock_work / before if self._rock is not None and before > 0.0 else None

    @property
    def efficiency_with_rebound(self) -> float | None:
        """η_2, the energy of a rebounding striker taken off the denominator (Lundberg 1987)."""
        spent = self.energy_before - (self.rigid_energy_after if self._balance.momentum_after < 0.0 else 0.0)
        return self.rock_work / spent if self._rock is not None and spent > 0.0 else None

    @property
    def greatest_penetration(self) -> float | None:
        """u_m, from the original surface of the rock; None without rock, as for the next ones."""
        return None if self._rock is None else self._rock.greatest * self._scales.length

    @property
    def residual_penetration(self) -> float | None:
        """u_r = (1 − γ) u_m."""
        return None if self._rock is None else self._rock.residual * self._scales.length

    @property
    def penetration_after(self) -> float | None:
        """Where the bit is at the end, from the original surface of the rock."""
        return None if self._rock is None else self._rock.after * self._scales.length

    @cached_property
    def penetration(self) -> Trace | None:
        """Where the bit is, from the original surface of the rock."""
        if self._rock is None:
            return None
        return self._scaled(self._course.trace(2 * self._course.size + 1), self._scales.length)

    @cached_property
    def bit_force(self) -> Trace | None:
        """The force on the rock."""
        if self._rock is None:
            return None
        return self._scaled(self._course.trace(2 * self._course.size + 2), self._scales.force)

    # -- waves --

    def waves_at(self, x: float) -> GaugeWaves:
        """The waves that pass a gauge on the rod, x from the struck face (m; dimensionless: time of a wave).

        Raises
        ------
        ParameterError
            For a place that is not on the rod, and for a wall.
        """
        rod = self._question.rod
        x = non_negative("x", x)
        if rod is None:
            raise ParameterError("x", x, "a place on a rod", "the target is a wall")
        starts = np.append(0.0, np.cumsum(rod.length))
        if x > starts[-1]:
            raise ParameterError("x", x, f"a place on the rod, from 0 to {starts[-1]:g}")
        number = min(int(np.searchsorted(starts, x, side="right")) - 1, rod.length.size - 1)
        section = self._course.striker + number
        delay = round((x - starts[number]) / rod.speed[number] / (self._scales.time * self._course.tick))
        z = float(rod.impedance[number]) * self._scales.velocity
        back = 0 if self._course.endless(section) else self._course.transit[section] - delay
        return GaugeWaves(
            self._scaled(self._course.trace(2 * section, delay), z),
            self._scaled(self._course.trace(2 * section + 1, back), -z),
            float(rod.impedance[number]),
        )

    @cached_property
    def first_pulse(self) -> Pulse | None:
        """The first pulse into the rod, at its face; None for a wall, and where no contact was."""
        if self._question.rod is None or not self.contacts:
            return None
        return first_pulse(self.waves_at(0.0), self.contacts[0].start)

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """Greatest compression and tension in each section of the striker, then of the rod."""
        rod = self._question.rod
        own = self._peaks(0, self._question.sections)
        return own if rod is None else own + self._peaks(self._course.striker, rod)

    @cached_property
    def _extremes(self) -> list[tuple[Extreme, Extreme]]:
        return force_extremes(self._course)

    def _peaks(self, first: int, sections: Sections) -> tuple[Peak, ...]:
        found = []
        starts = np.append(0.0, np.cumsum(sections.length))
        for i in range(sections.impedance.size):
            factor = self._scales.force / (1.0 if sections.area is None else float(sections.area[i]))
            told: list[Any] = []
            for extreme in self._extremes[first + i]:
                told.append(factor * extreme.force)
                along = None if extreme.place is None else extreme.place * self._scales.time * float(sections.speed[i])
                told.append(None if along is None else float(starts[i]) + along)
                told.append(None if extreme.time is None else extreme.time * self._scales.time)
            found.append(Peak(*told))
        return tuple(found)

    def state_at(self, time: float) -> StringState:
        """Force and velocity along striker and rod at a time in the window.

        Raises
        ------
        ParameterError
            For a time outside the window.
        """
        if not 0.0 <= finite("time", time) <= self.until:
            raise ParameterError("time", time, f"a time in the window, from 0 to {self.until:g}")
        tick = min(round(time / (self._scales.time * self._course.tick)), self._course.end)
        rod = self._question.rod
        return StringState(
            float(time),
            self._along(0, self._question.sections, tick),
            None if rod is None else self._along(self._course.striker, rod, tick),
        )

    def _along(self, first: int, sections: Sections, tick: int) -> AlongBody:
        places, force, velocity, section = along(self._course, first, sections, tick, self._scales.time)
        return AlongBody(places, force * self._scales.force, velocity * self._scales.velocity, section)

    # -- scales --

    @cached_property
    def _scales(self) -> Scales:
        return self._course.held.scales

    def _scaled(self, trace: Trace, factor: float) -> Trace:
        return trace.scaled(factor, self._scales.time)


def _mirrored(coefficients: Array) -> Array:
    """Pieces in the opposite direction, the last one first."""
    signs = np.ones(coefficients.shape[1])
    signs[1::2] = -1.0
    return np.asarray(coefficients[::-1] * signs)
