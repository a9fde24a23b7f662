"""The one dispatcher: a case and a question in, an answer object out."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.blows.transfer import Transfer, tool_of, transfer_dict
from percuss.case.answers.facts import (
    Fact,
    Teller,
    every,
    figures,
    json_number,
    json_of,
    number,
    picked,
    plain,
    plain_of,
    plain_value,
    rhythm,
)
from percuss.case.answers.heading import CLOCKED, Clocked, clocked_because, contact_dict, doubts, heading_dict
from percuss.case.answers.whole_hammer import FigureUncertainty, WholeHammer
from percuss.case.case import checked_case
from percuss.errors import ParameterError, PercussError
from percuss.model.body import need_free
from percuss.model.checks import count, several
from percuss.short_repr import ShortRepr
from percuss.stability import stability_of, timed_stability
from percuss.steady import ForceRecord, drag_of, greatest_drag, rest_on_wall, si_report, steady_states, timed_states
from percuss.steady.recorded.force_record import MeasuredForce, measured_load

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.explore.continuation.following import Reach, ReachEnd
    from percuss.model import Contact, System, Timed
    from percuss.recordings.history import HistoryReport
    from percuss.simulate import Ensemble
    from percuss.stability import Reduced, Stability, TimedStability
    from percuss.steady import Drag, Orbit, Rest, SIReport, SteadyStates, TimedOrbit, TimedStates


# ---- Where a handful of random starts end: whether a hammer that can sustain a motion also finds it


STARTS = 24
"""Starts that `percuss steady` follows: of those that end otherwise one in ten is missed once in twelve times."""

DISTRIBUTION, SEED = "wall", 0  # of the starts, as `percuss experiment` draws them when nothing else is asked for
_MOST_STARTS = 1000
_MOST_MODES = 64  # elastic modes; more of them cost time and change no end
_LEAST_IMPACTS = 200
_WORK = 5e8  # starts times impacts times modes times harmonics, about half a second
_EVALUATIONS = 200  # for every impact; machines need fewer than 50, a bar that hovers before the wall any number


@dataclass(frozen=True)
class End:
    """One of the motions in which starts end; `END` says what its figures are, None where nothing strikes any more."""

    label: str
    starts: int
    blow_rate: float | None
    delivered_power: float | None


@dataclass(frozen=True)
class Ends:
    """Where random starts end, the most frequent motion first; `note`: why none, or some not to their end."""

    followed: int
    modes: int
    impacts: int
    ends: tuple[End, ...]
    note: str = ""

    def to_json_dict(self, system: System) -> dict[str, Any]:
        """In plain values, with SI for a system that has scales."""
        return {
            **picked(self, "followed modes impacts note"),
            "distribution": DISTRIBUTION,
            "seed": SEED,
            "ends": [
                {**json_of(end, END, Teller.of(system)), "share": end.starts / self.followed} for end in self.ends
            ],
        }


END: tuple[Fact[End], ...] = (
    Fact("label", "motion", "what they settle on", "", "label"),
    Fact("starts", "starts", "how many", "", "starts"),
    Fact("blow_rate blow_rate_Hz", "main blows", "main blows per second", "cycles", "blow_rate"),
    Fact("delivered_power delivered_power_kW", "power", "power that the impacts take", "power",
         "delivered_power"),
)  # fmt: skip
"""What one of the ends is."""


def not_followed(why: str) -> Ends:
    """No starts, and the reason."""
    return Ends(0, 0, 0, (), why)


def ends_of(case: Case, starts: int = STARTS, modes: int | None = None) -> Ends:
    """Where random starts of a case end, the same starts and motions as `percuss experiment` with so many starts."""
    # A load of very many harmonics, and a bar that hovers, are followed for less, by numbers that no computer changes.
    from percuss.explore.attractors.experiments import experiment_job

    number = count("starts", starts, most=_MOST_STARTS)
    simulation = case.simulation()
    kept = min(simulation.modes if modes is None else modes, _MOST_MODES)
    size = case.load().harmonics.size
    enough = max(_LEAST_IMPACTS, int(_WORK / (number * (kept + 8) * (size + 8))))
    impacts = min(simulation.stop.most_impacts, enough)
    try:
        stop = replace(simulation.stop, periodic=True, impacts=impacts)
        job = experiment_job(case.system(), number, DISTRIBUTION, SEED, modes=kept, stop=stop)
    except ParameterError:
        raise
    except PercussError as error:  # an undamped mode in resonance has no bounded motion
        return not_followed(error.message)
    from percuss.explore.attractors.drawn_starts import named
    from percuss.simulate import simulate_many

    most = _EVALUATIONS * impacts
    drawn = named(case.system(), DISTRIBUTION, number, SEED)
    many = simulate_many(case.system(), drawn, modes=job.modes, stop=job.stop, work=most)
    long = int(np.count_nonzero(many.outcome == "work"))
    note = f"{long} of {number} not followed to their end: each would take more than {most} evaluations of its motion"
    return Ends(number, job.modes, job.stop.most_impacts, _ends(many), note if long else "")


def _ends(many: Ensemble) -> tuple[End, ...]:
    names, rate = many.label, many.main_blow_rate
    power = many.energy_lost_per_period / (2.0 * np.pi)
    return tuple(
        End(name, number, _mean(rate[names == name]), _mean(power[names == name]))
        for name, number in Counter(names.tolist()).most_common()
    )


def _mean(values: np.typing.NDArray[np.float64]) -> float | None:
    """Over what is known; None when nothing is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else None


# ---- How far a parameter may move before a motion is lost


@dataclass(frozen=True)
class CaseReach(ShortRepr):
    """How far one parameter of a case may move.

    Parameters
    ----------
    name, label, unit
        Of the parameter.
    value
        That of the case, in the unit.
    found
        How far it may move; None where it cannot be told.
    refusal
        Why not.
    """

    name: str
    label: str
    unit: str
    value: float
    found: Reach | None
    refusal: str = ""

    def __str__(self) -> str:
        return f"{self.label} = {self.words}"

    @property
    def words(self) -> str:
        """The sentence behind the name of the parameter."""
        unit = f" {self.unit}" if self.unit else ""
        head = f"{number(self.value)}{unit}"
        if self.found is None:
            return f"{head}: {self.refusal}"
        below, above = (
            _end_sentence(one, unit, self.name.rpartition(".")[2]) for one in (self.found.below, self.found.above)
        )
        return f"{head}: down to {below}; up to {above}"

    def to_json_dict(self) -> dict[str, Any]:
        """The same in plain values."""
        return {
            "parameter": self.name,
            **picked(self, "label unit value"),
            "below": None if self.found is None else _end_dict(self.found.below),
            "above": None if self.found is None else _end_dict(self.found.above),
            "text": str(self),
        }


_WHERE = {
    "fold": "where the motion ceases to exist",
    "nonsmooth_fold": "where the {blow} meets a step of the force and the motion ceases to exist",
    "flip": "where the period doubles",
    "neimark_sacker": "where the motion begins to waver",
    "branch_point": "where another motion takes over",
    "corner": "where the {blow} meets a step of the force and is no longer stable",
    "grazing_touch": "where the {bar} touches the wall between two {blow}s",
    "grazing_impact_dies": "where the {blow} has no speed left",
    "order_lost": "where two events of the valve exchange their order",
    "port_not_reached": "where the piston turns at a port and no longer reaches it",
    "turning_at_port": "where the piston turns at another port",
    "pressure_gone": "where the pressure falls to 0",
    "stall": "where the cycle comes to a standstill",
    "sticking": "where the {bar} would rest on the wall after {blow_}",
    "load_stops_pushing": "where the load stops pushing",
    "parameter_end": "beyond which there is no such {system}",
    "resonance": "where {mode_} resonates",
    "impacts_coalesce": "where two {blow}s fall together",
    "lost": "beyond which the motion could not be followed",
}
_HAMMER = {"bar": "bar", "blow": "blow", "blow_": "a blow", "system": "hammer", "mode_": "an elastic mode"}
_STRUCTURE = {"bar": "structure", "blow": "impact", "blow_": "an impact", "system": "structure", "mode_": "a mode"}
_LAST = {"restitution": (0.0, 1.0), "kappa": (0.0, 2.0)} | dict.fromkeys(
    ("d", "damping", "damping_ratio", "drag", "eta", "dashpot"), (0.0,)
)  # values beyond which there are none


def _end_sentence(end: ReachEnd, unit: str, name: str) -> str:
    if end.is_open:
        return f"{number(end.value)}{unit}{'' if end.value in _LAST.get(name, ()) else ' and further'}"
    machine = getattr(end.motion, "machine", None)  # of a cycle of a machine that switches its own valve
    names = _HAMMER if machine is not None or end.orbit.system.body.is_free else _STRUCTURE
    then = "" if end.then is None else f" (then {_then(end.then, names['blow'])})"
    return f"{number(end.value)}{unit}, {_WHERE.get(end.kind.value, end.kind.words).format(**names)}{then}"


def _then(label: str, blow: str) -> str:
    """``2 blows in 2 load periods`` or cycles, ``chatter to rest every load period``; other labels as they are."""
    if label.startswith("runs "):  # of a machine
        return rhythm(f"z={label.removeprefix('runs ')}", blow).replace("load period", "cycle")
    kind, _, periods = label.partition("/")
    if label.startswith("z="):
        return rhythm(label, blow)
    if kind in ("chatter", "rest") and periods.isdigit():
        return f"{'chatter to rest' if kind == 'chatter' else f'{blow}s and rest'} {every(int(periods))}"
    return label


def _end_dict(end: ReachEnd) -> dict[str, Any]:
    return {
        "type": end.kind.value,
        "value": json_number(end.value),
        "phase": None if hasattr(end.motion, "machine") else json_number(end.orbit.phase),
        "beyond": end.beyond,
        "then": end.then,
    }


# ---- What a law that knows the duration of the blow says of the steady motions of a case, beside B77's law


@dataclass(frozen=True)
class TimedAnswer(ShortRepr):
    """One steady motion whose blows take time, and its stability."""

    orbit: TimedOrbit
    stability: TimedStability

    @property
    def runs(self) -> bool:
        """Whether a hammer can sustain this motion: admissible and stable."""
        return self.orbit.admissible and self.stability.stable

    def to_json_dict(self, judged: Stability | None = None) -> dict[str, Any]:
        """The motion in plain values; with the verdict on the motion of B77's law, if it continues one."""
        start, end = self.orbit.contact
        told = {
            "contact_start": start,
            "contact_end": end,
            "margin_b77": None if judged is None else judged.margin_rhythm,
        }
        return plain_of(self, TIMED) | plain(told)

    @property
    def in_orbit(self) -> dict[str, Any]:
        """What stands in the motion of B77's law: both multipliers, and the advance in m or lengths of the bar."""
        orbit = self.orbit
        length = orbit.system.length_scale if orbit.system.is_si else 1.0
        advance = json_number(orbit.advance * length)
        return {"blow_multipliers": plain_value(self.stability.multipliers), "advance_per_blow": advance}


@dataclass(frozen=True)
class TimedPeriod(ShortRepr):
    """All motions with one blow in `states.periods` load periods under the law, in order of phase."""

    states: TimedStates
    orbits: tuple[TimedAnswer, ...]

    def continuing(self, orbit: Orbit) -> TimedAnswer | None:
        """The motion that continues one of B77's, or None where the duration of the blow ends it."""
        found = (one for one in self.orbits if one.orbit.phase_b77 == orbit.phase)
        return next(found, None)

    @property
    def alone(self) -> tuple[TimedAnswer, ...]:
        """The motions that continue none of B77's."""
        return tuple(one for one in self.orbits if one.orbit.b77 is None)

    def to_json_dict(self, judged: Mapping[float, Stability]) -> dict[str, Any]:
        """Level, existence and motions; with the verdicts on the motions of B77's law by their phases."""
        verdicts = (None if one.orbit.b77 is None else judged[one.orbit.b77.phase] for one in self.orbits)
        orbits = [one.to_json_dict(verdict) for one, verdict in zip(self.orbits, verdicts, strict=True)]
        return plain_of(self.states, TIMED_PERIOD) | {"orbits": orbits}


TIMED_PERIOD = figures(r"""
level | the right side of the condition on the phase, $c - a/T$ without damping
level_max | $\max (v_f - e\,p)$
exists | whether a steady state exists under the law
orbits | the motions of the law in order of phase, see below |
""")
TIMED = figures(r"""
phase | $\varphi$, load phase at the centroid of the force, in $[0, 2\pi)$ | orbit.phase
phase_b77 | the impact phase of the motion of B77's law that it continues; null if it continues none | orbit.phase_b77
phase_shift | how much later than by B77's law the force is centred, in radians; null without one | orbit.phase_shift
rigid_velocity | $V$, the mean velocity of the bar at the force's centroid without the blow | orbit.rigid_velocity
contact_velocity | the mean velocity at the start of the contact; not positive: no blow | orbit.contact_velocity
impulse | $J$ | orbit.impulse
blow_energy | $\frac12 V^2$ | orbit.blow_energy
energy_change | by how much that is greater than $\frac12 w_0^2$ of B77's motion; null without one | orbit.energy_change
delivered_energy | what of `blow_energy` goes through the face into what is struck | orbit.delivered_energy
ringing_energy | what of it rings on in the bar | orbit.ringing_energy
advance | $a$ | orbit.advance
contact_start | start of the contact, in radians after the centroid of the force |
contact_end | its end |
ringing_left | speed of the ringing at the next blow, over that of the blow | orbit.ringing_left
admissible | whether the bar strikes, and stays clear of the plane of impact between the blows | orbit.admissible
passage_time | when it first passes that plane, in radians after the centroid; null if never | orbit.violation.time
passage_depth | how far it passes it | orbit.violation.depth
stable | the verdict | stability.stable
reason | the verdict in words | stability.reason
margin | 1 minus the larger modulus of the two multipliers | stability.margin
margin_b77 | the `margin_rhythm` of B77's motion; null without one |
multipliers | both multipliers as pairs `[re, im]`, the larger modulus first | stability.multipliers
warnings | a list of texts: which assumptions of the law this motion does not keep | orbit.warnings
""")


def timed_period(system: System, law: Timed, periods: int, modes: int | None) -> TimedPeriod:
    """The answer of the law for one blow in so many load periods."""
    states = timed_states(system, law, periods, modes=modes)
    return TimedPeriod(states, tuple(TimedAnswer(orbit, timed_stability(orbit)) for orbit in states.orbits))


def blow_dict(law: Timed, system: System, periods: Sequence[int]) -> dict[str, Any]:
    """The numbers of the law, in SI or radians and bar lengths; the advance is that in the first of the `periods`."""
    time, length = (system.time_scale, system.length_scale) if system.is_si else (1.0, 1.0)
    period = 2.0 * math.pi * (periods[0] if periods else 1)
    advance = law.advance_per_impulse * law.steady_impulse(system.load.mean, period, system.d)
    return plain(
        {
            "law": law.law,
            "effective_restitution": law.restitution,
            "contact_duration": law.duration * time,
            "force_centroid": law.force_centroid * time,
            "advance_per_blow": advance * length,
            "ringing_share": law.ringing_share,
            "contacts": law.contacts,
        }
    )


# ---- Steady motions in plain values with the names that other programs read; every number finite or null


def rest_note(rest: Rest, contact: Contact) -> str:
    """What a possible rest leaves open of motions that fall onto the wall; empty under a law that keeps the strain."""
    # Seen in simulations of uniform bars under loads that never pull: at s = 20 the bar bounces on from R = 0.7 up, at
    # s = 200 from R = 0.65, at s = 2 at no R. A chatter of small bounces ends at rest under either law.
    if not rest.possible or contact.strain_factor == 1.0:
        return ""
    return (
        "As the impact turns the strain over, a bar that falls onto the wall may bounce on without end and never come "
        "to rest, in particular a stiff one with a large restitution; the random starts show whether it does"
    )


REST = figures(r"""
possible | the verdict by `least_contact_force`: true if the contact never has to pull
least_contact_force | the smallest contact force with every wave in the bar; null in resonance
phase | the load phase at which that force occurs
quasi_static | the smallest value of the load itself: the contact force without waves, which a simulation uses
lifted_by_waves | true if rest is not possible although the load never pulls: waves lift the end off for moments
held_by_waves | true if rest is possible although the load pulls at times; a simulation then releases the bar
note | what a motion that falls onto the wall may do instead of coming to rest; empty if there is nothing to add |
""")
PERIOD = figures(r"""
m | load periods per impact | periods
level | $c$ (B77 14)
level_max | $\max v_f$
exists | whether a steady state exists, `level` ≤ `level_max`
orbits | a list in order of phase, empty if none exists |
note | a remark on the roots of B77 (14), such as a continuum of motions; otherwise an empty text
nearest | null, or the nearest parameters at which a steady state exists, see below |
""")
ORBIT = figures(r"""
phase | $\varphi$, load phase at the impact, in $[0, 2\pi)$ | orbit.phase
impact_velocity | $u_t(1, 0^-)$ of the striking end; negative: it would leave the wall, no blow | orbit.impact_velocity
rigid_velocity | $w_0$, the same of the rigid motion | orbit.rigid_velocity
modes | elastic modes used | orbit.modes
error_bound | how much the omitted modes could change the end's motion; under steps an estimate | orbit.error_bound
admissible | whether the end strikes, and stays clear of the wall between impacts | orbit.admissible
proven | whether `admissible` and `violation` are proved, and not left open by ringing or error bound | orbit.proven
violation | null, or the first passage through the wall, see below |
stable | the verdict | stability.stable
reason | the verdict in words | stability.reason
margin | 1 minus the largest modulus of the multipliers; the smaller of the next two | stability.margin
margin_rhythm | the same for the two multipliers of the rigid motion: how fast blows find back | stability.margin_rhythm
margin_ringing | the same for the others: how fast the ringing dies; null without modes | stability.margin_ringing
reduced | the reduced criterion (B77 29–32), see below |
multipliers | the exact multipliers, see below |
disagreement | null, or how the reduced criterion and the exact multipliers differ | stability.disagreement
waveform | the waveform criterion, see below |
energy | over one period, see below |
drag | the drag of the damping on the bar as a whole, see below |
si | null for a dimensionless case, otherwise see below |
warnings | a list of texts | orbit.warnings
""")
REDUCED = figures(r"""
sigma | $\sigma$
a | $[a_0, a_1, a_2]$
schur | $[\lvert a_0/a_2\rvert, \lvert a_1/(a_0+a_2)\rvert]$, both less than 1 when stable
moduli | moduli of the two roots
stable | the verdict of this criterion
""")
MULTIPLIERS = figures(r"""
modes | elastic modes used in the multipliers
largest | the largest modulus
moduli | the moduli, from the largest down
dominant_mode | the mode with the greatest share in the first multiplier; 0 is the rigid motion
rigid | indices in `moduli`, from 0, of the two multipliers in which the rigid motion takes part most
ringing_mode | the mode with the greatest share in the largest of the others; 0 without elastic modes
""")
WAVEFORM = figures(r"""
ratio | $p(\varphi)/p_0$
lower | the band of `ratio` in which the motion is stable begins here
upper | and ends here
stable | the verdict of this criterion
force | `ratio` as a force
force_lower | `lower` as a force
force_upper | `upper` as a force
restitution_needed | the restitution below which a motion with this force would be stable, or null
""")
ENERGY = figures(r"""
input | work of the load
damping | energy that damping takes
impact | energy that the impact takes
imbalance | what is left of the balance; 0 if it closes
""")
DRAG = figures(r"""
force | $d\,w_0$, the drag on the rigid motion at its striking speed
of_mean | the same over the mean load
of_input | energy that damping takes, over the work of the load; null if the load does no work
""")


def with_blow(told: dict[str, Any], timed: TimedAnswer | None) -> dict[str, Any]:
    """A motion of B77's law with the phase of the motion that continues it when its blows take time; None for none."""
    phase = told["phase"] if timed is None else json_number(timed.orbit.phase)
    blow = {"blow_multipliers": None, "advance_per_blow": None} if timed is None else timed.in_orbit
    return {**told, "phase": phase, "phase_b77": told["phase"], **blow}


def reduced_dict(reduced: Reduced) -> dict[str, Any]:
    """B77's reduced criterion, with the other side of a jump of the load where there is one."""
    found, other = plain_of(reduced, REDUCED), reduced.other_side
    return found if other is None else {**found, "other_side": reduced_dict(other)}


# ---- The one dispatcher: a case and a question in, an answer object out


@dataclass(frozen=True)
class OrbitAnswer(ShortRepr):
    """One steady motion: the orbit, its stability and, for a case in SI, its report.

    `timed`: where the case has a law that knows the duration of the blow, the motion of that law which continues it.
    `ended`: whether there is none under that law.
    """

    orbit: Orbit
    stability: Stability
    si: SIReport | None
    timed: TimedAnswer | None = None
    ended: bool = False

    @property
    def drag(self) -> Drag:
        """What the damping does to the motion of the bar as a whole."""
        return drag_of(self.orbit)

    @property
    def runs(self) -> bool:
        """Whether a hammer can sustain this motion: admissible and stable, by the law of the case."""
        if self.ended:
            return False
        return self.orbit.admissible and self.stability.stable if self.timed is None else self.timed.runs

    @property
    def phase(self) -> float:
        """The phase of the blow by the law of the case."""
        return self.orbit.phase if self.timed is None else self.timed.orbit.phase

    def to_json_dict(self) -> dict[str, Any]:
        """The motion in plain values."""
        orbit, judged = self.orbit, self.stability
        if not orbit.system.body.is_free:
            return self._of_structure()
        told = plain_of(self, ORBIT) | {
            "violation": None if orbit.violation is None else picked(orbit.violation, "time depth"),
            "reduced": reduced_dict(judged.reduced),
            "multipliers": plain_of(judged.multipliers, MULTIPLIERS),
            "waveform": plain_of(judged.waveform, WAVEFORM),
            "energy": plain_of(orbit.energy, ENERGY),
            "drag": plain_of(self.drag, DRAG),
            "si": None if self.si is None else plain(asdict(self.si)),
        }
        return with_blow(told, self.timed) if self.ended or self.timed is not None else told

    def _of_structure(self) -> dict[str, Any]:
        orbit, system = self.orbit, self.orbit.system
        found = {
            **picked(orbit, "phase impact_velocity rebound_velocity blow_energy admissible fold"),
            "energy": picked(orbit.energy, "input damping impact"),
            "reason": None if orbit.obstacle is None else orbit.obstacle.value,
            "multipliers": plain_value(self.stability.multipliers.values),
            "stable": self.stability.stable,
        }
        if system.is_si:
            found["impact_velocity_m_s"] = json_number(orbit.impact_velocity * system.speed_scale)
            found["blow_energy_J"] = json_number(orbit.blow_energy * system.energy_scale)
        return found


@dataclass(frozen=True)
class PeriodAnswer(ShortRepr):
    """All steady motions with one impact in `states.periods` load periods, in order of phase.

    `greatest_drag`: where there is none, the greatest d with which there is one, all else kept; None without one.
    `timed`: the same by a law that knows the duration of the blow, where the case has one.
    """

    states: SteadyStates
    orbits: tuple[OrbitAnswer, ...]
    greatest_drag: float | None = None
    timed: TimedPeriod | None = None

    def to_json_dict(self) -> dict[str, Any]:
        """The motions in plain values; of a structure the level is its gap, and the place of its contact meets it."""
        states, orbits = self.states, [one.to_json_dict() for one in self.orbits]
        if not states.system.body.is_free:
            places = {"gap": json_number(states.level), "greatest_place": json_number(states.level_max)}
            return {**picked(states, "periods modes"), **places, "note": states.note, "orbits": orbits}
        told, nearest = plain_of(states, PERIOD) | {"orbits": orbits}, states.nearest
        if nearest is not None:
            told["nearest"] = {**picked(nearest, "load_factor restitution"), "d": json_number(self.greatest_drag)}
        if self.timed is not None:
            told["blow"] = self.timed.to_json_dict({one.orbit.phase: one.stability for one in self.orbits})
        return told


@dataclass(frozen=True)
class SteadyAnswer(ShortRepr):
    """The answer to "what steady motions does this hammer, or this structure that is held, have?".

    Attributes
    ----------
    system
        The system; `system.load.report` tells of a recorded history.
    notes
        What was assumed in reading the recording and of the load's clock.
    periods
        One entry for every number m of load periods that was asked for.
    rest, starts
        Lying on the wall for all time, None of a structure; and where random starts end.
    law
        The law of a blow that takes time, where the case names one; None for B77's impact.
    reach
        How far parameters may move before `chosen` is lost (`percuss.case.reach_answer`); None unless it was asked for.
    tool
        The blow on the rod that the case describes, at any speed; None without one.
    plausibility
        Whether figures that no hammer has are told of.
    uncertainty
        What the ± of the numbers of the case leaves of the figures; None where none has one, or it was
        not asked (`percuss.case.uncertainty_of`).
    record
        The record that the load was made from; None of another load.
    """

    name: str
    title: str
    system: System
    notes: tuple[str, ...]
    periods: tuple[PeriodAnswer, ...]
    rest: Rest | None
    starts: Ends = field(default_factory=lambda: not_followed("none were asked for"))
    law: Timed | None = None
    reach: tuple[CaseReach, ...] | None = None
    tool: BlowQuestion | None = None
    plausibility: bool = True
    uncertainty: FigureUncertainty | None = None
    record: ForceRecord | None = None

    @cached_property
    def measured(self) -> MeasuredForce | None:
        """The record beside the load that was made from it."""
        return None if self.record is None else measured_load(self.system, self.record)

    @property
    def told_notes(self) -> tuple[str, ...]:
        """The notes, and which figures of `chosen` no hammer has."""
        chosen = self.chosen if self.plausibility else None
        return self.notes if chosen is None else (*self.notes, *doubts(chosen.orbit))

    @cached_property
    def whole(self) -> WholeHammer:
        """The hammer in the motion `chosen`, with what it strikes."""
        stopped = "no steady motion" if self.chosen is None else "" if self.chosen.runs else "the motion is not kept"
        return WholeHammer(None if self.chosen is None else self.chosen.orbit, stopped, self.tool)

    @property
    def transfer(self) -> Transfer | None:
        """Where the energy of `chosen` goes, into tool and rock; None without a rod to strike, or a blow."""
        return self.whole.transfer

    @property
    def history(self) -> HistoryReport | None:
        """What was found in the recording, or None when the load is a formula."""
        return self.system.load.report

    @property
    def running(self) -> tuple[OrbitAnswer, ...]:
        """The admissible and stable orbits, fewest load periods per impact first."""
        found = [answer for period in self.periods for answer in period.orbits if answer.runs]
        return tuple(sorted(found, key=lambda answer: answer.orbit.periods))

    @property
    def clocked(self) -> Clocked | None:
        """Why the verdict turns on the load's keeping time by itself; None where it does not."""
        levels = [(period.states.level, period.states.level_max) for period in self.periods]
        motions = [(found.orbit.admissible, found.runs) for period in self.periods for found in period.orbits]
        return clocked_because(self.system.load, levels, motions)

    @property
    def chosen(self) -> OrbitAnswer | None:
        """The orbit to look at first: a running one, else an admissible one, else any; None without orbits."""
        found = [answer for period in self.periods for answer in period.orbits]
        ranked = sorted(found, key=lambda a: (not a.runs, not a.orbit.admissible, a.orbit.periods))
        return ranked[0] if ranked else None

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss steady --json` prints it."""
        head = heading_dict(self.name, self.title, self.system, self.told_notes)
        periods = [period.to_json_dict() for period in self.periods]
        reach = None if self.reach is None else [one.to_json_dict() for one in self.reach]
        if self.rest is None:
            return {**head, "periods": periods} | ({} if reach is None else {"reach": reach})
        return {
            **head,
            **self._blow(),
            "clocked": None if self.clocked is None else {"because": self.clocked, "note": CLOCKED},
            "periods": periods,
            "rest": plain_of(self.rest, REST) | {"note": rest_note(self.rest, self.system.contact)},
            "starts": plain(self.starts.to_json_dict(self.system)),
            "reach": reach,
            **({} if self.tool is None else transfer_dict(self.transfer)),
            **({} if self.uncertainty is None else {"uncertainty": self.uncertainty.to_json_dict()}),
        }

    def _blow(self) -> dict[str, Any]:
        """The law of the blow, where it takes time."""
        if self.law is None:
            return {}
        asked = [period.states.periods for period in self.periods]
        contact = {**contact_dict(self.system), "law": self.law.law}
        return {"contact": contact, "blow": blow_dict(self.law, self.system, asked)}


def steady_answer(
    case: Case, periods: Sequence[int] = (1,), modes: int | None = None, *, starts: int = 0
) -> SteadyAnswer:
    """All steady motions of a case with one impact in m load periods, for every m of `periods`.

    Parameters
    ----------
    modes
        Elastic modes for the mode sums and for the multipliers; by default the sums take as many as their
        tolerance needs and the multipliers 32.
    starts
        How many random starts of a free bar to follow besides, 0 to 1000; see `percuss experiment`.

    Raises
    ------
    LoadError
        When the load is constant, or does not push a free bar.
    ResonanceError
        When an undamped mode is driven at its own frequency.
    CaseError
        When the recording of the case cannot be used.

    Examples
    --------
    >>> from percuss.case import Case, load_case
    >>> answer = steady_answer(load_case("laboratory-striker"))
    >>> [found.stability.stable for found in answer.periods[0].orbits]
    [False, True]

    A structure that is held:

    >>> tables = '''
    ... [body]
    ... kind = "mounted"
    ... spring = 0.25
    ... [system]
    ... restitution = 0.8
    ... [load]
    ... kind = "harmonic"
    ... mean = 0.0
    ... amplitude = 0.25
    ... '''
    >>> [round(found.orbit.impact_velocity, 9) for found in steady_answer(Case.from_text(tables)).periods[0].orbits]
    [3.333333333, -3.333333333]
    """
    checked_case(case)
    asked = several("periods", periods, "whole numbers of load periods, such as [1, 2]")
    system, law = case.system(), case.timed_law()
    found = [_period_answer(system, law, m, modes) for m in asked]
    if number := count("starts", starts, least=0):
        need_free(system.body, "the random starts of this answer")
    ends = ends_of(case, number, modes) if number else not_followed("none were asked for")
    rest = rest_on_wall(system) if system.body.is_free else None
    record = None if case.recorded_force is None else ForceRecord(*case.recorded_force)
    return SteadyAnswer(
        case.file, case.title, system, case.notes, tuple(found), rest, ends, law, tool=tool_of(case), record=record
    )


def _period_answer(system: System, law: Timed | None, m: int, modes: int | None) -> PeriodAnswer:
    timed = None if law is None else timed_period(system, law, m, modes)
    states = steady_states(system, m, modes=modes) if timed is None else timed.states.b77
    orbits = tuple(judged(orbit, timed) for orbit in states.orbits)
    return PeriodAnswer(states, orbits, greatest_drag(system, m) if states.nearest is not None else None, timed)


def judged(orbit: Orbit, timed: TimedPeriod | None = None) -> OrbitAnswer:
    """A steady motion with its verdict and, of a bar in SI, its figures."""
    free = orbit.system.body.is_free
    si = si_report(orbit) if orbit.system.is_si and free else None
    found = None if timed is None else timed.continuing(orbit)
    ended = timed is not None and found is None
    return OrbitAnswer(orbit, stability_of(orbit, modes=None if free else orbit.modes), si, found, ended)
