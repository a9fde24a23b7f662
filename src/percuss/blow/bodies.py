"""The striker as a chain of sections: impedances, transit times, where they lie, and areas where they are known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np

from percuss.errors import ParameterError
from percuss.model import Body, Section, SizedBody, SteppedBar, UniformBar
from percuss.model.body.stepped import MOST_JUMP, MOST_SECTIONS, pieces_of, section_of
from percuss.model.body.uniform import Piece
from percuss.model.checks import Array, choice, count, finite, instance, non_negative, positive, several

# ---- What is struck: a rigid wall, or a rod of sections with what is at its far end, such as a bit on rock

End = Literal["infinite", "free", "fixed", "rock"]
ENDS: tuple[End, ...] = ("infinite", "free", "fixed", "rock")  # what a rod can have at its far end


@dataclass(frozen=True)
class Rock:
    """Rock under a bit: a spring that yields, and that cannot pull (Lundberg 1973).

    The force rises with the penetration along `stiffness` while the bit goes deeper than ever before. Back and again
    forward it goes along the steeper `stiffness`/`unloading_ratio`; the rest of the penetration remains.

    Parameters
    ----------
    stiffness, gap
        K_1 of the first loading, in N/m, and the distance between bit and rock before the blow, in m.
    unloading_ratio
        γ, the share of the penetration that springs back, greater than 0 and at most 1, dimensionless; 1 is elastic.

    Examples
    --------
    >>> Rock(4e8, unloading_ratio=0.4).unloading_stiffness
    1000000000.0
    """

    stiffness: float
    unloading_ratio: float = 1.0
    gap: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", positive("stiffness", self.stiffness))
        accepted = "a number greater than 0 and at most 1"
        ratio = finite("unloading_ratio", self.unloading_ratio, accepted)
        if not 0.0 < ratio <= 1.0:
            raise ParameterError("unloading_ratio", self.unloading_ratio, accepted)
        object.__setattr__(self, "unloading_ratio", ratio)
        object.__setattr__(self, "gap", non_negative("gap", self.gap))

    @property
    def unloading_stiffness(self) -> float:
        """K_2 = K_1/γ in N/m."""
        return self.stiffness / self.unloading_ratio


@dataclass(frozen=True)
class Wall:
    """A rigid wall, at a gap ≥ 0 from the striker before the blow, in m (dimensionless: in lengths of the striker)."""

    gap: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "gap", non_negative("gap", self.gap))


JointKind = Literal["mass", "elastic", "contact"]
JOINTS: dict[JointKind, tuple[str, ...]] = {
    "mass": ("mass",), "elastic": ("stiffness", "damping"), "contact": ("slack",),
}  # fmt: skip
"""The kinds of joints, and what each is described by."""


@dataclass(frozen=True)
class Joint:
    """What joins two sections of a rod other than rigidly; without a mass of its own unless it is one.

    Parameters
    ----------
    at
        The step, counted from 1: between the sections `at` − 1 and `at`, counted from 0.
    kind
        "mass": a lumped mass, such as a sleeve. "elastic": a spring with a parallel dashpot. "contact": two faces that
        push and never pull, until a thread catches them.
    mass, stiffness, damping
        In kg; in N/m; in N·s/m.
    slack
        How far the faces of a "contact" part before its thread bears tension, in m; None: without limit, 0: glued.

    Examples
    --------
    >>> Joint(1, "contact", slack=1e-4)
    Joint(at=1, kind='contact', mass=0.0, stiffness=0.0, damping=0.0, slack=0.0001)
    """

    at: int
    kind: JointKind = "mass"
    mass: float = field(default=0.0, kw_only=True)
    stiffness: float = field(default=0.0, kw_only=True)
    damping: float = field(default=0.0, kw_only=True)
    slack: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        count("at", self.at, 1, MOST_SECTIONS)
        choice("kind", self.kind, *JOINTS)
        for name in ("mass", "stiffness", "damping"):
            object.__setattr__(self, name, non_negative(name, getattr(self, name)))
        if self.slack is not None:
            object.__setattr__(self, "slack", non_negative("slack", self.slack))
        for name in ("mass", "stiffness", "damping", "slack"):
            if name not in JOINTS[self.kind] and getattr(self, name):
                accepted = f"no {name} of a joint of the kind {self.kind}"
                raise ParameterError(
                    name, getattr(self, name), accepted, "two joints have a short section between them"
                )
        if self.kind == "elastic":
            positive("stiffness", self.stiffness)


@dataclass(frozen=True)
class Feed:
    """What presses a tool against the rock: Q = max(0, F − k_d y − c_d y') at one of its nodes.

    y is the displacement of the node toward the rock since the static state.

    Parameters
    ----------
    force
        F, in N, 0 or greater.
    at
        The node: 0 the struck face, n the n-th step of the rod.
    stiffness, damping
        Of a recoil damper: k_d in N/m, and c_d in N·s/m, which absorbs most where it is the impedance of the rod.

    Examples
    --------
    >>> Feed(8e3, damping=2e4).at
    0
    """

    force: float
    at: int = 0
    stiffness: float = 0.0
    damping: float = 0.0

    def __post_init__(self) -> None:
        count("at", self.at, 0, MOST_SECTIONS)
        for name in ("force", "stiffness", "damping"):
            object.__setattr__(self, name, non_negative(name, getattr(self, name)))


@dataclass(frozen=True)
class Rod:
    """A rod at rest in front of the striker, free of stress but for that of its feed.

    Parameters
    ----------
    sections
        From the struck face on, each a `Section`, or a dict of what makes one. With the end "infinite" the last one,
        and only that, has the length None.
    end, rock
        What is at the far end: "infinite" (nothing ever comes back), "free", "fixed", or "rock", with the `Rock`.
    bit_mass
        Mass in kg lumped at a free end or in front of the rock; may be 0. A bit with a length is one more section.
    joint_masses
        Pairs (step, mass): masses in kg lumped between the sections, step 1 between the first and the second; short
        for `joints` of the kind "mass".
    joints
        What joins sections other than rigidly, each a `Joint`; at most one at a step.
    attenuation
        α in 1/m, of each section, or one number for all: what of a wave departs from the static state falls by the
        factor e^{−αx} over a length x. Kept as one number for each section.
    feed
        What presses the rod against rock or a rigid support; None: nothing does.
    gap
        Distance between the faces before the blow, in m.
    impedance
        Of an endless rod of which nothing else is known: see `Rod.of_impedance`.

    Examples
    --------
    >>> drill = Rod([Section(1.2, diameter=0.038), Section(0.1, diameter=0.06)], "rock", bit_mass=3.0, rock=Rock(4e8))
    >>> len(drill.pieces), drill.end
    (2, 'rock')
    >>> Rod([Section(None, diameter=0.038)]).end
    'infinite'
    """

    sections: tuple[Section, ...]
    end: End = "infinite"
    bit_mass: float = field(default=0.0, kw_only=True)
    joint_masses: tuple[tuple[int, float], ...] = field(default=(), kw_only=True)
    joints: tuple[Joint, ...] = field(default=(), kw_only=True)
    attenuation: tuple[float, ...] = field(default=(), kw_only=True)
    feed: Feed | None = field(default=None, kw_only=True)
    rock: Rock | None = field(default=None, kw_only=True)
    gap: float = field(default=0.0, kw_only=True)
    impedance: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        given = several("sections", self.sections, "a list of sections")
        object.__setattr__(self, "sections", tuple(section_of(i, one) for i, one in enumerate(given)))
        choice("end", self.end, *ENDS)
        object.__setattr__(self, "bit_mass", non_negative("bit_mass", self.bit_mass))
        object.__setattr__(self, "gap", non_negative("gap", self.gap))
        object.__setattr__(self, "joint_masses", _joint_masses(self.joint_masses, len(self.sections)))
        object.__setattr__(self, "joints", several("joints", self.joints, "a list of joints"))
        object.__setattr__(self, "attenuation", _attenuation(self.attenuation, len(self.sections)))
        if self.impedance is None:
            self._check_lengths()
        else:
            object.__setattr__(self, "impedance", positive("impedance", self.impedance))
            if self.sections or self.end != "infinite":
                raise ParameterError("impedance", self.impedance, "an endless rod without sections")
        self._check_end()
        self._check_joints()
        self._check_feed()

    @classmethod
    def of_impedance(cls, impedance: float, gap: float = 0.0) -> Rod:
        """An endless rod by its impedance alone, in the units of the striker's; no areas, so no stresses.

        N·s/m where the striker has sizes; of a dimensionless striker mass × angular frequency, in which a uniform bar
        has the impedance s. ParameterError for values out of range.
        """
        return cls((), gap=gap, impedance=positive("impedance", impedance))

    def _check_lengths(self) -> None:
        if not 1 <= len(self.sections) <= MOST_SECTIONS:
            raise ParameterError("sections", f"{len(self.sections)} of them", f"1 to {MOST_SECTIONS} sections")
        last = len(self.sections) - 1
        for i, section in enumerate(self.sections):
            endless = self.end == "infinite" and i == last
            if endless and section.length is not None:
                remedy = 'leave the length out, or say what is at the end: "free", "fixed" or "rock"'
                raise ParameterError(f"sections[{i}].length", section.length, "none: the rod has no end", remedy)
            if not endless and section.length is None:
                remedy = 'only the last section of a rod with the end "infinite" has none'
                raise ParameterError(f"sections[{i}].length", None, "a length in m", remedy)
        for i, (one, other) in enumerate(pairwise(piece.area for piece in self.pieces), 1):
            if max(one, other) >= MOST_JUMP * min(one, other):
                wanted = f"an area that differs from its neighbour's by a factor of less than {MOST_JUMP:,.0f}"
                raise ParameterError(f"sections[{i}].area", other, wanted, "check the units of its sizes")

    def _check_end(self) -> None:
        if self.rock is not None:
            instance("rock", self.rock, Rock)
        if (self.rock is None) == (self.end == "rock"):
            remedy = "give the rock, or another end" if self.end == "rock" else 'say end="rock"'
            raise ParameterError("rock", self.rock, f"{'a' if self.end == 'rock' else 'no'} Rock at this end", remedy)
        if self.bit_mass > 0.0 and self.end not in ("free", "rock"):
            raise ParameterError("bit_mass", self.bit_mass, f"0: the end is {self.end}", 'only "free" and "rock" move')

    def _check_joints(self) -> None:
        for i, joint in enumerate(self.joints):
            instance(f"joints[{i}]", joint, Joint)
            if joint.at >= max(1, len(self.sections)):
                wanted = f"a step from 1 to {len(self.sections) - 1}" if len(self.sections) > 1 else "no joint: no step"
                raise ParameterError(f"joints[{i}].at", joint.at, wanted, "step 1 is behind the first section")
            if any(joint.at == other.at for other in self._given_joints if other is not joint):
                wanted = "one joint at a step"
                raise ParameterError(
                    f"joints[{i}].at", joint.at, wanted, "two joints have a short section between them"
                )

    def _check_feed(self) -> None:
        if self.feed is None:
            return
        instance("feed", self.feed, Feed)
        if self.end not in ("rock", "fixed"):
            remedy = 'say end="rock" and describe the rock, or leave the feed out'
            wanted = f"no feed: the {self.end} end of the rod does not bear it"
            raise ParameterError("feed", self.feed.force, wanted, remedy)
        if self.rock is not None and self.rock.gap > 0.0:
            remedy = "leave the gap out: a bit that is fed stands on the rock before the blow"
            raise ParameterError("feed", self.feed.force, "no feed beside a gap in front of the rock", remedy)
        if self.feed.at >= len(self.sections):
            wanted = f"a node from 0, the struck face, to {len(self.sections) - 1}, the last step"
            raise ParameterError("feed.at", self.feed.at, wanted)
        joint = self.joint_at.get(self.feed.at)
        if joint is not None and joint.kind != "mass":
            wanted = f"a step without a joint of the kind {joint.kind}"
            raise ParameterError("feed.at", self.feed.at, wanted, "put a short section between feed and joint")

    @property
    def _given_joints(self) -> tuple[Joint, ...]:
        return (*self.joints, *(Joint(step, mass=mass) for step, mass in self.joint_masses))

    @cached_property
    def joint_at(self) -> dict[int, Joint]:
        """The joints by their steps, those of `joint_masses` among them."""
        return {joint.at: joint for joint in self._given_joints}

    @property
    def is_held(self) -> bool:
        """Whether it has a feed, joints other than rigid ones, or steel that attenuates waves."""
        return self.feed is not None or bool(self.joint_at) or any(self.attenuation)

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """Its sections from the struck face on; the last one of an endless rod ends at infinity."""
        return pieces_of(self.sections)

    @property
    def end_impedance(self) -> float:
        """Impedance at the far end."""
        return self.pieces[-1].impedance if self.impedance is None else self.impedance


Target: TypeAlias = Wall | Rod
"""What is struck."""


def _joint_masses(given: Iterable[Any], sections: int) -> tuple[tuple[int, float], ...]:
    accepted = "pairs (number of the step, mass in kg)"
    pairs = [several("joint_masses", pair, accepted) for pair in several("joint_masses", given, accepted)]
    if any(len(pair) != 2 for pair in pairs):
        raise ParameterError("joint_masses", given, accepted)
    if pairs and sections < 2:
        raise ParameterError("joint_masses", given, "none: one section has no steps")
    found = [(count("joint_masses", step, 1, sections - 1), non_negative("joint_masses", m)) for step, m in pairs]
    if len({step for step, _ in found}) < len(found):
        raise ParameterError("joint_masses", given, "one mass at a step")
    return tuple(found)


def _attenuation(given: Any, sections: int) -> tuple[float, ...]:
    accepted = f"one number in 1/m, or one for each of {sections} sections"
    found = (given,) * max(1, sections) if isinstance(given, int | float) else several("attenuation", given, accepted)
    found = found or (0.0,) * max(1, sections)
    if len(found) != max(1, sections):
        raise ParameterError("attenuation", given, accepted)
    values = tuple(non_negative(f"attenuation[{i}]", alpha) for i, alpha in enumerate(found))
    if sections == 0 and any(values):
        raise ParameterError("attenuation", given, "0 of a rod of which only the impedance is known")
    return values


# ---- The striker as a chain of sections: impedances, transit times, where they lie, and areas where they are known

Striker = SizedBody | Body  # what strikes: with its sizes in SI, or dimensionless


@dataclass(frozen=True)
class Sections:
    """A row of sections, (K,), endless ones with inf; a rod of which only Z is known has speed 1: places are times."""

    impedance: Array
    transit: Array
    length: Array
    speed: Array
    area: Array | None


def striker_sections(striker: Striker) -> Sections:
    """The sections of a striker from the driven end on."""
    if isinstance(striker, SizedBody):
        return _of_pieces(striker.pieces)
    if isinstance(striker, SteppedBar):
        chain = striker.sections
        return Sections(chain.impedance, chain.transit, chain.width, 1.0 / chain.slowness, None)
    if isinstance(striker, UniformBar):
        return Sections(
            np.array([striker.s]), np.array([striker.transit_time]), np.ones(1), np.array([striker.s]), None
        )
    raise ParameterError("striker", striker, "a bar: Bar, SectionedBar, UniformBar or SteppedBar")


def rod_sections(rod: Rod, striker: Striker) -> Sections:
    """The sections of a rod from the struck face on, in the units of the striker."""
    if rod.impedance is not None:
        endless = np.array([np.inf])
        return Sections(np.array([rod.impedance]), endless, endless, np.ones(1), None)
    if not isinstance(striker, SizedBody):
        raise ParameterError("target", rod, "a wall, or Rod.of_impedance", "a dimensionless striker has no sizes")
    return _of_pieces(rod.pieces)


def _of_pieces(pieces: tuple[Piece, ...]) -> Sections:
    return Sections(
        np.array([piece.impedance for piece in pieces]),
        np.array([piece.transit_time for piece in pieces]),
        np.array([piece.end - piece.start for piece in pieces]),
        np.array([(piece.youngs_modulus / piece.density) ** 0.5 for piece in pieces]),
        np.array([piece.area for piece in pieces]),
    )
