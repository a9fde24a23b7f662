"""Blows without rock in rational arithmetic: every wave is constant between events, so not one number is rounded.

A second program beside the package, made only to judge it: one loop from event to event, lists of what is under way
in each section, no tolerance anywhere. Where a wave meets a lumped mass or a rock it is no longer constant; such blows
are refused.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise

from collisions import Collision

ZERO = Fraction(0)


@dataclass
class Way:
    """Waves that run one way through one section: when each value enters, and from when on it leaves."""

    transit: Fraction | None
    leaving: Fraction
    entered: list[tuple[Fraction, Fraction]]
    under_way: deque[tuple[Fraction, Fraction]] = field(default_factory=deque)

    def arrive(self, now: Fraction) -> None:
        while self.under_way and self.under_way[0][0] <= now:
            self.leaving = self.under_way.popleft()[1]

    def enter(self, now: Fraction, value: Fraction) -> None:
        if value != self.entered[-1][1]:
            self.entered.append((now, value))
            if self.transit is not None:
                self.under_way.append((now + self.transit, value))

    def inside(self, now: Fraction) -> Iterator[tuple[Fraction, Fraction]]:
        """(duration, value) of what is in the section."""
        assert self.transit is not None
        start, value = now, self.leaving
        for arrival, new in self.under_way:
            yield arrival - start, value
            start, value = arrival, new
        yield now + self.transit - start, value

    def pieces(self, until: Fraction) -> list[tuple[Fraction, Fraction, Fraction]]:
        """(start, end, value) of all that ever entered, what was inside at first included."""
        ends = [start for start, _ in self.entered[1:]] + [until]
        return [(a, b, value) for (a, value), b in zip(self.entered, ends, strict=True) if b > a]


@dataclass
class Section:
    impedance: Fraction
    right: Way
    left: Way

    def momentum(self, now: Fraction) -> Fraction:
        ways = (self.right, self.left)
        return self.impedance * sum((time * value for way in ways for time, value in way.inside(now)), ZERO)

    def energy(self, now: Fraction) -> Fraction:
        ways = (self.right, self.left)
        return self.impedance * sum((time * value**2 for way in ways for time, value in way.inside(now)), ZERO)


def _section(impedance: Fraction, transit: Fraction | None, velocity: Fraction) -> Section:
    half, start = velocity / 2, ZERO if transit is None else -transit
    return Section(impedance, Way(transit, half, [(start, half)]), Way(transit, half, [(start, half)]))


@dataclass
class Outcome:
    """What the program found; `face` has (start, end, force) of every piece, open ones with force 0."""

    collision: Collision
    striker: list[Section]
    rod: list[Section]
    face: list[tuple[Fraction, Fraction, Fraction]]
    work_through_face: Fraction
    load_work: Fraction
    load_impulse: Fraction
    endless_energy: Fraction
    endless_momentum: Fraction
    gap_after: Fraction
    events: int

    @property
    def contacts(self) -> list[tuple[Fraction, Fraction | None, Fraction, Fraction]]:
        """(start, end, impulse, peak force); end None where still closed."""
        found: list[tuple[Fraction, Fraction | None, Fraction, Fraction]] = []
        last = None
        for start, end, force in self.face:
            if force > 0:
                if last == start:
                    begun, _, impulse, peak = found.pop()
                    found.append((begun, end, impulse + force * (end - start), max(peak, force)))
                else:
                    found.append((start, end, force * (end - start), force))
                last = end
        if found and found[-1][1] == self.collision.until:
            found[-1] = (found[-1][0], None, *found[-1][2:])
        return found

    @property
    def impulse(self) -> Fraction:
        return sum((force * (end - start) for start, end, force in self.face), ZERO)

    @property
    def momentum_after(self) -> Fraction:
        return sum((one.momentum(self.collision.until) for one in self.striker), ZERO)

    @property
    def velocity_after(self) -> Fraction:
        return self.momentum_after / self.collision.mass

    @property
    def restitution(self) -> Fraction:
        return -self.velocity_after / self.collision.velocity_before

    @property
    def striker_energy_after(self) -> Fraction:
        return sum((one.energy(self.collision.until) for one in self.striker), ZERO)

    @property
    def rigid_energy_after(self) -> Fraction:
        return self.collision.mass * self.velocity_after**2 / 2

    @property
    def vibration_energy_after(self) -> Fraction:
        return self.striker_energy_after - self.rigid_energy_after

    @property
    def rod_energy_after(self) -> Fraction:
        """Of the sections, and of what has left into an endless one."""
        finite = [one for one in self.rod if one.right.transit is not None]
        return self.endless_energy + sum((one.energy(self.collision.until) for one in finite), ZERO)

    @property
    def rod_momentum_after(self) -> Fraction:
        finite = [one for one in self.rod if one.right.transit is not None]
        return self.endless_momentum + sum((one.momentum(self.collision.until) for one in finite), ZERO)

    @property
    def force_centroid(self) -> Fraction:
        """From the start of the first contact, over all contacts."""
        start = self.contacts[0][0]
        moment = sum((force * (b - a) * ((a + b) / 2 - start) for a, b, force in self.face), ZERO)
        return moment / self.impulse

    def peak_forces(self, section: Section) -> tuple[Fraction, Fraction]:
        """Greatest compression and tension (as positive numbers, 0 when there is none) in a section of finite length.

        Two waves meet when some emission s of the one and r of the other satisfy |s − r| < τ within the window.
        """
        until, tau = self.collision.until, section.right.transit
        assert tau is not None
        pairs = [(f[2] - g[2], f, g) for f in section.right.pieces(until) for g in section.left.pieces(until)]
        best = []
        for sign in (1, -1):
            ordered = sorted(pairs, key=lambda pair: -sign * pair[0])
            met = next(force for force, f, g in ordered if _meet(f[:2], g[:2], tau, until))
            best.append(max(ZERO, sign * section.impedance * met))
        return best[0], best[1]


def _meet(f: tuple[Fraction, Fraction], g: tuple[Fraction, Fraction], tau: Fraction, until: Fraction) -> bool:
    """Whether the rectangle of emissions and the strip of meetings in the window have an area in common."""
    corners = [(f[0], g[0]), (f[1], g[0]), (f[1], g[1]), (f[0], g[1])]
    limits = ((1, -1, tau), (-1, 1, tau), (-1, -1, tau), (1, 1, 2 * until - tau))  # a s + b r < c
    for a, b, c in limits:
        kept = []
        for (s, r), (s_next, r_next) in zip(corners, corners[1:] + corners[:1], strict=True):
            here, there = c - a * s - b * r, c - a * s_next - b * r_next
            if here >= 0:
                kept.append((s, r))
            if here * there < 0:
                share = here / (here - there)
                kept.append((s + share * (s_next - s), r + share * (r_next - r)))
        corners = kept
        if len(corners) < 3:
            return False
    following = corners[1:] + corners[:1]
    return sum(s * r_next - s_next * r for (s, r), (s_next, r_next) in zip(corners, following, strict=True)) != 0


def blow(given: Collision) -> Outcome:
    """The blow, exactly."""
    case = given.turned_into(Fraction)
    assert case.end in ("infinite", "free", "fixed") and not case.joint_masses and not case.bit_mass
    striker = [_section(z, tau, v) for (z, tau), v in zip(case.striker, case.velocity, strict=True)]
    rod = [_section(z, tau, ZERO) for z, tau in case.rod or ()]
    ways = [way for one in striker + rod for way in (one.right, one.left)]
    out = Outcome(case, striker, rod, [], *[ZERO] * 5, case.gap, 0)
    now, gap = ZERO, case.gap
    while now < case.until:
        for way in ways:
            way.arrive(now)
        force = next((value for start, value in reversed(case.load) if start <= now), ZERO)
        speed = _inside(striker, now, case.load_at, force)
        _inside(rod, now, -1, ZERO)
        _far_end(case, rod, now)
        contact, face_speed, rate = _face(striker, rod, now, gap)
        times = [way.under_way[0][0] for way in ways if way.under_way]
        times += [start for start, _ in case.load if start > now]
        if gap > 0 and rate < 0:
            times.append(now - gap / rate)
        then = min([case.until, *times])
        step = then - now
        out.face.append((now, then, contact))
        out.work_through_face += contact * face_speed * step
        out.load_work += force * speed * step
        out.load_impulse += force * step
        if rod and rod[-1].right.transit is None:
            last = rod[-1]
            out.endless_energy += last.impedance * last.right.entered[-1][1] ** 2 * step
            out.endless_momentum += last.impedance * last.right.entered[-1][1] * step
        gap += rate * step
        now, out.events = then, out.events + 1
    for way in ways:
        way.arrive(now)
    out.gap_after = gap
    return out


def _inside(sections: list[Section], now: Fraction, load_at: int, force: Fraction) -> Fraction:
    """The driven end of a striker and the steps of a chain; the speed where the load acts."""
    speed = ZERO
    if sections and load_at >= 0:  # a striker's
        first, pushed = sections[0], force if load_at == 0 else ZERO
        value = first.left.leaving + pushed / first.impedance
        first.right.enter(now, value)
        speed = value + first.left.leaving
    for i, (one, other) in enumerate(pairwise(sections), 1):
        f, g, pushed = one.right.leaving, other.left.leaving, force if i == load_at else ZERO
        v = (2 * one.impedance * f + 2 * other.impedance * g + pushed) / (one.impedance + other.impedance)
        one.left.enter(now, v - f)
        other.right.enter(now, v - g)
        speed = v if i == load_at else speed
    return speed


def _far_end(case: Collision, rod: list[Section], now: Fraction) -> None:
    if rod and case.end != "infinite":
        f = rod[-1].right.leaving
        rod[-1].left.enter(now, f if case.end == "free" else -f)


def _face(
    striker: list[Section], rod: list[Section], now: Fraction, gap: Fraction
) -> tuple[Fraction, Fraction, Fraction]:
    """The force in the face, the speed of the rod's face, and the rate of the gap."""
    z, f = striker[-1].impedance, striker[-1].right.leaving
    g = rod[0].left.leaving if rod else ZERO
    if gap > 0 or f <= g:  # open: both faces are free
        striker[-1].left.enter(now, f)
        if rod:
            rod[0].right.enter(now, g)
        return ZERO, 2 * g, 2 * (g - f)
    if not rod:
        striker[-1].left.enter(now, -f)
        return 2 * z * f, ZERO, ZERO
    other = rod[0].impedance
    v = 2 * (z * f + other * g) / (z + other)
    striker[-1].left.enter(now, v - f)
    rod[0].right.enter(now, v - g)
    return 2 * z * other * (f - g) / (z + other), v, ZERO
