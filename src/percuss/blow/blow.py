"""One blow: its balances, and contacts, forces and stresses, each computed from the waves when it is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from percuss.blow.bodies import Sections, Striker, Target
from percuss.blow.fields import (
    AlongBody,
    CellsOverTime,
    EnergyOverTime,
    ForceEnvelope,
    StringState,
    along,
    cells,
    energy_over_time,
    envelope,
    force_peaks,
    force_turns,
)
from percuss.blow.figures import BlowOutcome, ContactInterval, Fineness, Peak, Pulse
from percuss.blow.gauges import GaugeWaves, first_pulse
from percuss.blow.kernels.wave_records import ROCK
from percuss.blow.wave_history import Trace, WaveHistory, centroid, contacts, gap
from percuss.errors import ParameterError
from percuss.model.checks import Array, array, count, finite, non_negative, positive

# ---- Where the energy and the momentum of a blow are at its end, and how well both close


@dataclass(frozen=True, eq=False)
class BlowBalance:
    """Energies and momenta before a blow and at the end of its window.

    Attributes
    ----------
    energy_before
        Kinetic and strain energy of the striker.
    mean_velocity_before, mean_velocity_after
        V_0 and V_1, momentum over mass.
    striker_momentum_after
        M V_1.
    effective_restitution
        R_eff = −V_1/V_0; None for a striker without momentum before.
    impulse
        J = ∫ N dt over the window.
    restitution_from_impulse
        J/(M V_0) − 1: R_eff without a load, and with one what B77's law makes of this impulse.
    load_work
        Work of the load.
    rigid_energy_after
        M V_1²/2: given back to the machine where the striker rebounds.
    vibration_energy_after
        The ringing of the striker.
    work_through_face
        ∫ N v dt of the rod's face: what rod, bit and rock have got.
    rod_energy, rod_momentum
        Of the rod, its energy with masses at its joints; what an endless one took.
    bit_kinetic_energy_after
        Of the mass lumped at the far end.
    rock_work, rock_dissipated
        Work done on the rock, and what of it is not given back, (1 − γ) K_1 u_m²/2 (Lundberg 1973); 0 without rock.
    greatest_penetration, residual_penetration, penetration_after
        u_m, u_r = (1 − γ) u_m, and where the bit is at the end, from the original surface; None without rock.
    tool_energy_before
        Strain energy of the static state under the feed, or what an earlier blow left in sections and bit.
    feed_force_work, recoil_spring_work, recoil_damper_loss, feed_work
        Work of a constant feed force and of the spring while the feed acts, what the dashpot has taken, and
        ∫ Q v dt in all.
    steel_loss, joint_loss
        What attenuation has taken from the rod, preload included, and what the dashpots of joints have.
    joint_energy_change
        Of masses at joints and of elastic joints, which `rod_energy` holds as well.
    tool_dynamic_energy
        Of the waves in the sections of the rod that have an end, where they depart from the static state.
    energy_out_of_the_end
        What has gone down an endless section.
    tool_momentum
        Of the sections of the rod that have an end, and of the bit.
    feed_impulse
        ∫ Q dt of the feed.
    face_advance
        How far the struck face has moved.
    momentum_error, energy_error
        By how much they do not close, relative to what there was of them; energy in striker or rod.
    """

    energy_before: float
    mean_velocity_before: float
    mean_velocity_after: float
    striker_momentum_after: float
    effective_restitution: float | None
    impulse: float
    restitution_from_impulse: float | None
    load_work: float
    rigid_energy_after: float
    vibration_energy_after: float
    work_through_face: float
    rod_energy: float
    rod_momentum: float
    bit_kinetic_energy_after: float
    rock_work: float
    rock_dissipated: float
    greatest_penetration: float | None
    residual_penetration: float | None
    penetration_after: float | None
    tool_energy_before: float
    feed_force_work: float
    recoil_spring_work: float
    recoil_damper_loss: float
    steel_loss: float
    joint_loss: float
    joint_energy_change: float
    tool_dynamic_energy: float
    energy_out_of_the_end: float
    tool_momentum: float
    feed_impulse: float
    face_advance: float
    momentum_error: float
    energy_error: float

    @property
    def feed_work(self) -> float:
        """∫ Q v dt of the feed."""
        return self.feed_force_work + self.recoil_spring_work - self.recoil_damper_loss

    @property
    def tool_energy_after(self) -> float:
        """Kinetic and strain energy of the sections that end and the bit."""
        return self.rod_energy - self.joint_energy_change - self.energy_out_of_the_end + self.bit_kinetic_energy_after


def balance(course: WaveHistory) -> BlowBalance:
    """The balance of a blow: waves, work through the face and the rock's law are summed by themselves, and compared."""
    striker, size, end, scales = course.striker, course.size, course.end, course.scales
    before, momentum = course.energy(0, striker, 0), course.momentum(0, striker, 0)
    after, left = course.energy(0, striker, end), course.momentum(0, striker, end)
    impulse = course.sums(2 * size, 0, end).plain
    load_impulse, load_work = _load(course)
    rigid = 0.5 * left * left / course.mass
    through, rod, rod_momentum, lumped, bit, begun, advance, static, tool, gone, dynamic = (0.0,) * 11
    feed, steel, rubbed = course.feed_work(), 0.0, 0.0
    if course.has_rod:
        # ∫ N v dt of the rod's face: the power of a wave is Z f² − Z g²
        row = 2 * striker
        sent, back = course.sums(row, 0, end), course.arrived(row + 1, 0, end)
        through, advance = float(course.impedance[striker]) * (sent.square - back.square), sent.plain + back.plain
        rod, rod_momentum = course.energy(striker, size, end), course.momentum(striker, size, end)
        joints, bits = course.lumped_energy([end])
        lumped, bit = float(joints[0]), float(bits[0])
        if course.held.struck_before:
            joints, bits = course.lumped_energy([0])
            lumped, begun = lumped - float(joints[0]), float(bits[0])
        if course.feed_node == striker:  # N of the face is that in the rod less Q
            through += course.preload(striker) * advance - feed.total
        known = course.ending
        static = begun + course.energy(striker, known, 0)
        gone, dynamic = course.energy(known, size, end), course.dynamic_energy(striker, known, end)
        tool = course.momentum(striker, known, end) + course.lumped_momentum(end)[1]
        rubbed, steel = course.joint_loss(), course.lost_on_the_way(end)[0]
    work, dissipated, depths = _rock(course)
    scale = max(before, abs(load_work), abs(through), 1e-300)
    lost = work + steel + rubbed
    errors = before + load_work - after - through, through + feed.total + static - rod - lumped - bit - lost
    push = max(abs(momentum), abs(impulse), abs(load_impulse), (course.mass * before) ** 0.5, 1e-300)
    deepest, residual, now = (None if depth is None else depth * scales.length for depth in depths)
    return BlowBalance(
        energy_before=before * scales.energy,
        mean_velocity_before=momentum / course.mass * scales.velocity,
        mean_velocity_after=left / course.mass * scales.velocity,
        striker_momentum_after=left * scales.momentum,
        effective_restitution=0.0 - left / momentum if momentum != 0.0 else None,
        impulse=impulse * scales.momentum,
        restitution_from_impulse=impulse / momentum - 1.0 if momentum != 0.0 else None,
        load_work=load_work * scales.energy,
        rigid_energy_after=rigid * scales.energy,
        vibration_energy_after=max(0.0, after - rigid) * scales.energy,
        work_through_face=through * scales.energy,
        rod_energy=(rod + lumped) * scales.energy,
        rod_momentum=rod_momentum * scales.momentum,
        bit_kinetic_energy_after=bit * scales.energy,
        rock_work=work * scales.energy,
        rock_dissipated=dissipated * scales.energy,
        greatest_penetration=deepest,
        residual_penetration=residual,
        penetration_after=now,
        tool_energy_before=static * scales.energy,
        feed_force_work=feed.constant * scales.energy,
        recoil_spring_work=feed.spring * scales.energy,
        recoil_damper_loss=feed.damper * scales.energy,
        steel_loss=steel * scales.energy,
        joint_loss=rubbed * scales.energy,
        joint_energy_change=lumped * scales.energy,
        tool_dynamic_energy=dynamic * scales.energy,
        energy_out_of_the_end=gone * scales.energy,
        tool_momentum=tool * scales.momentum,
        feed_impulse=feed.impulse * scales.momentum,
        face_advance=advance * scales.length,
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


def _rock(course: WaveHistory) -> tuple[float, float, tuple[float | None, ...]]:
    """Work on the rock, what of it is lost, and the penetrations: the greatest, what remains, at the end."""
    problem = course.held.problem
    if problem.end != ROCK:
        return 0.0, 0.0, (None, None, None)
    if course.held.state.time[course.size] == course.end:
        greatest = float(course.held.state.now[0].greatest)
    else:  # the bit has been followed beyond the window
        trace = course.trace(2 * course.size + 1)
        greatest = max(0.0, float(trace.before(trace.times[1:]).max()))
    force = course.value(2 * course.size + 2, course.end)
    before, fed = float(course.crater), course.preload(course.size - 1)
    if course.held.struck_before:
        fed = course.value(2 * course.size + 2, 0)
    dissipated = 0.5 * (1.0 - problem.ratio) * problem.stiffness * (greatest**2 - before**2)
    stored = 0.5 * (force**2 - fed**2) / problem.unloading
    depths = greatest, (1.0 - problem.ratio) * greatest, course.value(2 * course.size + 1, course.end)
    return dissipated + stored, dissipated, depths


# ---- One blow: contacts, forces, stresses


@dataclass(frozen=True, eq=False, repr=False)
class Blow(BlowBalance):
    """One blow, from the first instant of its window to `until`; made by `strike`.

    Forces in N, times in s, energies in J where the striker has sizes. Of a dimensionless striker everything is in
    the scales mass 1, length 1, angular frequency 1. Velocities are positive toward the target, forces are positive
    in compression. Energies and momenta are those of `BlowBalance`.

    Attributes
    ----------
    velocity
        Of each section before the blow, shape (K,); None where a field was given.
    fineness
        How finely its waves were followed.
    """

    striker: Striker
    target: Target
    velocity: Array | None
    until: float
    outcome: BlowOutcome
    fineness: Fineness
    _course: WaveHistory

    def __repr__(self) -> str:
        return f"<Blow of {self.striker} until {self.until:.6g}: {self.outcome.value}>"

    # -- contact --

    @cached_property
    def face_force(self) -> Trace:
        """The force between the faces."""
        return self._row(2 * self._course.size, self._course.scales.force)

    @cached_property
    def _contacts(self) -> tuple[tuple[ContactInterval, ...], int]:
        return contacts(self._course)

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
    def gap_after(self) -> float:
        """Distance between the faces."""
        return 0.0 if self._course.in_contact else gap(self._course) * self._course.scales.length

    # -- energies --

    @property
    def striker_mass(self) -> float:
        """Mass of the striker."""
        own = self._course.held.own
        return float(np.dot(own.impedance, own.transit))

    @cached_property
    def kinetic_energy_before(self) -> float:
        """Of the striker."""
        course, own, found = self._course, self._course.held.own, 0.0
        if self.velocity is not None:
            return float(0.5 * np.sum(own.impedance * own.transit * self.velocity**2))
        for i in range(course.striker):
            back = course.transit[i]
            right, left = (course.trace(row, 0, -back, 0) for row in (2 * i, 2 * i + 1))
            signs = 1.0 - 2.0 * (np.arange(right.coefficients.shape[1]) % 2)
            mirrored = Trace(-right.times[::-1] - back * course.tick, right.coefficients[::-1] * signs)
            found += float(course.impedance[i]) * mirrored.product_integral(left)
        return 0.5 * self.energy_before + found * course.scales.energy

    @cached_property
    def rock_impulse(self) -> float:
        """∫ F dt on the rock over the window; 0 without rock."""
        course = self._course
        return course.sums(2 * course.size + 2, 0, course.end).plain * course.scales.momentum

    @property
    def penetration_before(self) -> float | None:
        """The greatest before the blow, under the feed or of the crater; None without rock."""
        return None if self.greatest_penetration is None else self._course.crater * self._course.scales.length

    @property
    def tool_momentum_error(self) -> float | None:
        """By how much J + ∫ Q dt − ∫ F dt is not the momentum of the tool; relative to J, None without rock."""
        course = self._course
        if self.greatest_penetration is None:
            return None
        braked, masses = course.lost_on_the_way(course.end)[1], course.lumped_momentum(course.end)[0]
        rest = self.impulse + self.feed_impulse - self.rock_impulse - self.tool_momentum
        if course.held.struck_before:
            masses -= course.momentum(course.striker, course.ending, 0) + sum(course.lumped_momentum(0))
        rest -= (braked + masses) * course.scales.momentum
        return abs(rest) / max(abs(self.impulse), abs(self.rock_impulse), 1e-300)

    @property
    def rock_stored(self) -> float:
        """What of the work on the rock it could still give back."""
        return self.rock_work - self.rock_dissipated

    @property
    def efficiency(self) -> float | None:
        """η_1, work on the rock over the energy before; None without rock or energy."""
        return self._rock_share(self.energy_before)

    @property
    def efficiency_with_rebound(self) -> float | None:
        """η_2, the energy of a rebounding striker taken off the denominator (Lundberg 1987)."""
        rebound = self.rigid_energy_after if self.mean_velocity_after < 0.0 else 0.0
        return self._rock_share(self.energy_before - rebound)

    def _rock_share(self, spent: float) -> float | None:
        return self.rock_work / spent if self.greatest_penetration is not None and spent > 0.0 else None

    @cached_property
    def penetration(self) -> Trace | None:
        """Where the bit is, from the original surface of the rock; None without rock."""
        course = self._course
        return None if self.greatest_penetration is None else self._row(2 * course.size + 1, course.scales.length)

    @cached_property
    def bit_force(self) -> Trace | None:
        """The force on the rock; None without rock."""
        course = self._course
        return None if self.greatest_penetration is None else self._row(2 * course.size + 2, course.scales.force)

    def _row(self, row: int, scale: float) -> Trace:
        return self._course.trace(row).scaled(scale, self._course.scales.time)

    # -- waves --

    def waves_at(self, x: float) -> GaugeWaves:
        """The waves that pass a gauge on the rod, x from the struck face (m; dimensionless: time of a wave).

        ParameterError for a place that is not on the rod, and for a wall.
        """
        course, (rod, number, place) = self._course, self._section_at(x)
        section, time = course.striker + number, course.scales.time
        delay = round(place / rod.speed[number] / (time * course.tick))
        back = 0 if course.endless(section) else course.transit[section] - delay
        z = float(rod.impedance[number]) * course.scales.velocity
        incident, reflected = course.trace(2 * section, delay), course.trace(2 * section + 1, back)
        one, other = (z * float(course.fade(section, ticks * course.tick)) for ticks in (delay, back))
        z, static = float(rod.impedance[number]), course.preload(section) * course.scales.force
        return GaugeWaves(incident.scaled(one, time), reflected.scaled(-other, time), z, static)

    def _section_at(self, x: float) -> tuple[Sections, int, float]:
        """The rod's sections, which of them has a place, and how far in it that is."""
        rod, x = self._course.held.rod, non_negative("x", x)
        if rod is None:
            raise ParameterError("x", x, "a place on a rod", "the target is a wall")
        starts = np.append(0.0, np.cumsum(rod.length))
        if x > starts[-1]:
            raise ParameterError("x", x, f"a place on the rod, from 0 to {starts[-1]:g}")
        number = min(int(np.searchsorted(starts, x, side="right")) - 1, rod.length.size - 1)
        return rod, number, float(x - starts[number])

    def force_range_at(self, x: float) -> tuple[float, float]:
        """The greatest and the least force at a place on the rod, as `waves_at` takes it, the preload with it."""
        rod, number, place = self._section_at(x)
        if self._course.endless(self._course.striker + number):
            incident = self.waves_at(x).incident
            return incident.peak, -incident.scaled(-1.0).peak
        turns = self.force_turns(self._course.striker + number, np.array([place / rod.length[number]]))[0]
        return float(turns.max()), float(turns.min())

    @cached_property
    def first_pulse(self) -> Pulse | None:
        """The first pulse into the rod, at its face; None for a wall, and where no contact was."""
        if self._course.held.rod is None or not self.contacts:
            return None
        return first_pulse(self.waves_at(0.0), self.contacts[0].start)

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """Greatest compression and tension in each section of the striker, then of the rod."""
        return force_peaks(self._course)

    def state_at(self, time: float) -> StringState:
        """Force and velocity along striker and rod at a time in the window.

        ParameterError for a time outside the window.
        """
        if not 0.0 <= finite("time", time) <= self.until:
            raise ParameterError("time", time, f"a time in the window, from 0 to {self.until:g}")
        course = self._course
        tick = min(round(time / (course.scales.time * course.tick)), course.end)

        def told(first: int, sections: Sections) -> AlongBody:
            return along(course, first, sections, tick)

        return StringState(float(time), *course.of_each(told))

    def cells_over_time(self, times: Array, size: int, reach: float) -> tuple[CellsOverTime, CellsOverTime | None]:
        """Force and velocity at times in the window, in about so many cells of the striker, and of the rod.

        `reach`: how far an endless section is told of, in the units of the rod's places.

        Examples
        --------
        >>> from percuss.blow import Wall, strike
        >>> from percuss.model import UniformBar
        >>> own, rod = strike(UniformBar(1.0), Wall(), 1.0).cells_over_time(np.array([0.5]), 4, 1.0)
        >>> own.force.round(9).tolist(), rod
        ([[0.0, 0.0, 1.0, 1.0]], None)
        """
        course = self._course
        times, size = array("times", times, 0.0, np.inf), count("size", size, 1, 100_000)
        reach = positive("reach", reach)
        ticks = np.clip(times / (course.scales.time * course.tick), 0.0, course.end)
        return course.of_each(lambda first, sections: cells(course, first, sections, ticks, size, reach))

    def energy_over_time(self, times: Array) -> EnergyOverTime:
        """Where the energy is at times in the window; together with the work of the load it stays the same.

        Examples
        --------
        >>> from percuss.blow import Wall, strike
        >>> from percuss.model import UniformBar
        >>> found = strike(UniformBar(1.0), Wall(), 1.0).energy_over_time(np.array([0.0, 1.0, 2.0]))
        >>> found.rigid.round(9).tolist(), found.vibration.round(9).tolist()
        ([0.5, 0.0, 0.5], [0.0, 0.5, 0.0])
        """
        return energy_over_time(self._course, array("times", times, 0.0, np.inf))

    def force_envelope(self, size: int, reach: float) -> tuple[ForceEnvelope, ForceEnvelope | None]:
        """The greatest forces at every place of the striker, and of the rod; `size`, `reach` as `cells_over_time`.

        Stepwise waves are looked at between all their breaks, which is exact; bent waves, and those of very many
        pieces, at 4000 instants. `peaks` has the greatest of each section, always exact; ParameterError for a number of
        cells below 1, and a reach that is not positive.

        Examples
        --------
        >>> from percuss.blow import Wall, strike
        >>> from percuss.model import SectionedBar, Section
        >>> blow = strike(SectionedBar([Section(0.2, area=1e-3), Section(0.2, area=2e-3)]), Wall(), 10.0)
        >>> bool(blow.force_envelope(8, 1.0)[0].compression.max() <= blow.face_force.peak)
        True
        """
        size, reach = count("size", size, 1, 100_000), positive("reach", reach)
        return self._course.of_each(lambda first, sections: envelope(self._course, first, sections, size, reach))

    def force_turns(self, section: int, shares: Array) -> tuple[Array, ...]:
        """The force over the window at places of one section, by its turning points, which are exact.

        Parameters
        ----------
        section
            Its number: those of the striker from the driven end, then those of the rod from the struck face.
        shares
            Places as shares of its length from 0 to 1, shape (n,); 0 of an endless section.

        Returns
        -------
        tuple of Array
            For each place the values before and after each step, and where the force turns between them, in turn.

        Examples
        --------
        >>> from percuss.blow import Wall, strike
        >>> from percuss.model import UniformBar
        >>> strike(UniformBar(1.0), Wall(), 1.0).force_turns(0, np.array([0.5]))[0].round(9).tolist()
        [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]
        """
        course = self._course
        number, places = count("section", section, 0, course.size - 1), array("shares", shares, 0.0, 1.0)
        if course.endless(number) and places.any():
            raise ParameterError("shares", shares, "0 in an endless section: what passes its start passes everywhere")
        return force_turns(course, number, places)
