"""The engine: the numbers of a system as the kernels want them, the state of its motion, and the loop around them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.mechanics.held_structure import HeldMotion, HeldStructure, Modal, held_structure
from percuss.model import HeldBody, Kept, Load, System
from percuss.model.body import Body
from percuss.model.checks import Array
from percuss.model.system import half_swing, rests, wall_load
from percuss.simulate.events import RELEASE, Events, MotionCycle, joined, label_of, unresolved
from percuss.simulate.kernels import motion_records as kn
from percuss.simulate.kernels.bounds import bounded
from percuss.simulate.kernels.clock import release_phases
from percuss.simulate.kernels.motion import follow, put_first
from percuss.simulate.spectrum import Anchor, DampedModes, Spectrum, spectrum_of
from percuss.simulate.start import Start
from percuss.simulate.stop import Stop

# ---- The numbers of one system as the kernels want them, computed once for all its motions

_EQUAL = 4.0 * np.finfo(float).eps
_AWAY = 1e-2  # of a radian of the load or of the highest mode: how long several modes are away at least, once let go
_RIPPLE = 1e-3  # of a radian of a structure's one mode: how soon it is looked at again after a release


@lru_cache(maxsize=16)
def prepared(system: System, modes: int) -> tuple[Spectrum, kn.MotionTable]:
    """Spectrum and table of a system, kept for the next motion of it; ResonanceError at a resonance (B77 16)."""
    return spectrum_of(system, modes), table_of(system, modes)


def table_of(system: System, modes: int) -> kn.MotionTable:
    """The kernels' table of a system cut at mode N; its `bar` is the caller's own, which the kernels change."""
    # Its neighbours in a map, with another restitution or mean load, share all but a few numbers of it. ResonanceError
    # when a harmonic of the load meets an undamped elastic mode (B77 16).
    load = system.load
    harmonics = () if load.is_piecewise else tuple(load.coefficients.tolist())[1:]
    shared = _without_mean(system.body, load.at, harmonics, modes)
    bar = _copied(shared.bar)
    bar["restitution"], bar["strain"] = -system.contact.velocity_factor, system.contact.strain_factor
    bar["bears"], bar["pushing"] = 1.0, _longest_push(load)
    bar["force"] = float(np.abs(load.values).max()) if load.is_piecewise else abs(load.mean) + shared.bar["force"]
    wall, waves = load, shared.harmonics
    if isinstance(system.body, HeldBody):
        wall = _held(bar, system, modes)
        waves = waves._replace(load_re=bar["bears"] * waves.load_re, load_im=bar["bears"] * waves.load_im)
    set_load(bar, load.mean)
    if load.is_piecewise:
        steps, breaks = np.array(wall.values), np.array(load.breaks)
        releases = breaks[(steps < 0.0) & (np.roll(steps, 1) >= 0.0)]
        return shared._replace(bar=bar, breaks=breaks, values=np.array(load.values), releases=releases)
    found = _releases(system.body, load.at, tuple(wall.coefficients.tolist())[1:], modes, wall.mean)
    return shared._replace(bar=bar, harmonics=waves, releases=found)


def set_load(bar: np.void, value: float) -> None:
    """The constant part of the load, as the kernels set it (`clock.set_load`)."""
    bar["load"], bar["mean"] = value, 0.0 if bar["held"] else value
    bar["wall"] = bar["bears"] * value + bar["preload"]


def _held(bar: np.void, system: System, modes: int) -> Load:
    """What the kernels know of a structure, which has no rigid motion; the force at the wall that pulls it off."""
    # Of one mode that is an affine image of the load. Several modes move on while the wall holds their contact: they
    # are not released, and whether they stay on the wall is told by their acceleration.
    bar["held"], bar["contact"], bar["pushing"] = 1.0, 0.0, 0.0
    if not rests(system, modes):
        bar["bears"] = 0.0
        return system.load.scaled(0.0)
    known, wall = system.body.modes(1, system.load.at), wall_load(system, 1)
    bar["damping"] = known.damping[0]  # of no rigid motion, but by which a chatter ends
    bar["ripple"], bar["wave"] = _RIPPLE / (1.0 + float(known.omega[0])), half_swing(known)
    bar["bears"] = np.copysign(1.0, known.gamma[0])
    bar["preload"] = wall.mean - bar["bears"] * system.load.mean
    return wall


def to_change(table: kn.MotionTable) -> kn.MotionTable:
    """A table with a `bar` of its own, which the kernels change."""
    return table._replace(bar=_copied(table.bar))


def _copied(bar: np.void) -> np.void:
    """A copy in one piece: `copy` takes an impact's time for each field, and `np.array` shares the memory."""
    found: np.void = np.ndarray(1, kn.BAR, bytearray(bar.tobytes()))[0]
    return found


@lru_cache(maxsize=16)
def _without_mean(body: Body, at: int, harmonics: tuple[complex, ...], modes: int) -> kn.MotionTable:
    """The table but for the contact, the mean load, and what follows from them; none for a load of steps."""
    load = Load(np.array([0.0, *harmonics]), at=at)
    spectrum = Spectrum(System(body, load, Kept(0.0)), modes)
    k, pk, response = spectrum.k, spectrum.pk, spectrum.response
    bar = bar_of(body, spectrum)
    for order, name in enumerate(("reach", "rate", "curve", "jerk")):
        bar[name] = float(np.sum(k**order * np.abs(spectrum.gap))) * (1.0 + 1e-12)
    bar["force"] = float(np.abs(pk).sum())
    bar["bend"] = float(np.sum(k**2 * np.abs(pk))) * (1.0 + 1e-12)
    bar["sway"] = float(np.sum(k * np.abs(spectrum.rigid)))
    bar["swing"] = bar["sway"] + float(np.sum(k[:, None] * np.abs(response)))
    parts = (part for values in (spectrum.gap, spectrum.rigid, pk) for part in (values.real, values.imag))
    coupling = np.ascontiguousarray(np.stack([response.real, response.imag], axis=1))
    none = np.empty(0)
    return kn.MotionTable(
        bar,
        tabled_modes(spectrum, bar),
        kn.Harmonics(*(np.array(part, order="C") for part in parts)),
        coupling,
        none,
        none,
        none,
    )


def bar_of(body: Body, modes: DampedModes) -> np.void:
    """The numbers of a bar that do not depend on its load; all others are 0."""
    bar: np.void = np.zeros(1, kn.BAR)[0]
    bar["damping"], bar["whole"], bar["ripple"] = body.rigid_drag, 1.0, 1e-3
    if modes.omega.size:
        bar["wave"] = (1.0 + 0.5 / modes.omega.size) * body.transit_time
        bar["ripple"] = 0.5 * np.pi / modes.omega[-1]
    bar["contact"] = 2.0 * body.transit_time
    return bar


def tabled_modes(spectrum: DampedModes, bar: np.void) -> kn.ModeTable:
    """The elastic modes, and what `bar` says of all of them."""
    if not spectrum.omega.size:
        return NO_MODES
    omega, damping, creeps = spectrum.omega.copy(), spectrum.damping.copy(), spectrum.creeps
    oscillates, half = np.where(creeps, 0.0, 1.0), 0.5 * damping
    lam = spectrum.lam
    delta = np.zeros(omega.size)
    bar["law"] = law = _law(omega, damping, creeps)
    own = half[~creeps]
    bar["quickest"], bar["base"] = omega.max(), omega[0] if law == kn.POWERS else lam[0]
    rates = half.copy()
    rates[creeps] = np.minimum(half, omega * omega / np.where(creeps, damping, 1.0))[creeps]  # d/2 − κ ≥ ω²/d
    bar["linger"] = rates.min()
    if law == kn.POWERS:
        bar["half"] = half[0]
        delta = oscillates * half * half / (omega + lam)
        bar["delta"] = delta.max()
    elif law == kn.RATIO:
        bar["base_half"] = half[0]
    bar["wane"], slowest = (2.0 * own.max(), 2.0 * own.min()) if own.size else (0.0, np.inf)
    bar["lasting"] = 2.0 / slowest if slowest > 1e-300 else np.inf
    return kn.ModeTable(
        omega=omega,
        lam=oscillates * lam,
        inverse=oscillates / lam,
        square=oscillates * spectrum.square,
        signed=np.array(spectrum.square),
        damping=damping,
        half=oscillates * half,
        delta=delta,
        oscillates=oscillates,
        statics=spectrum.statics,
        unit=spectrum.unit,
        inertia=0.5 * spectrum.inertia,
        creeping=np.flatnonzero(creeps),
    )


NO_MODES = kn.ModeTable._make([*np.empty((12, 0)), np.empty(0, dtype=np.int64)])


def _law(omega: Array, damping: Array, creeps: npt.NDArray[np.bool_]) -> int:
    """How the phasors of the modes are computed best, see `percuss.simulate.kernels.motion_records`."""
    number = np.arange(1.0, omega.size + 1.0)
    if np.any(np.abs(omega - number * omega[0]) > _EQUAL * omega):
        return kn.SINGLY
    if np.all(damping == damping[0]):
        return kn.POWERS
    ratio = np.all(np.abs(damping - number * damping[0]) <= _EQUAL * damping)
    return kn.RATIO if ratio and not creeps.any() else kn.SINGLY


_SAMPLES = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)


@lru_cache(maxsize=1024)
def _longest_push(load: Load) -> float:
    """A bound, from above, of the time for which the load does not pull; inf when no sample of it does."""
    pulls = np.flatnonzero(load.value(_SAMPLES) < 0.0)
    if not pulls.size:
        return np.inf
    return float(np.diff(pulls, append=pulls[0] + _SAMPLES.size).max() * _SAMPLES[1])


@lru_cache(maxsize=1024)
def _releases(body: Body, at: int, harmonics: tuple[complex, ...], modes: int, mean: float) -> Array:
    """Phases at which a Fourier series begins to pull."""
    shared = _without_mean(body, at, harmonics, modes)
    found = np.empty(shared.harmonics.gap_re.size)
    force = abs(mean) + float(shared.bar["force"])
    return np.unique(found[: release_phases(shared.harmonics, mean, float(shared.bar["bend"]), force, found)])


# ---- The whole state of a simulation between two events, as the records that the kernels change

Records = npt.NDArray[Any]

_OFF = 8.0 * np.finfo(float).eps  # of a time: a few products and its own last digit


@dataclass(frozen=True)
class Snapshot:
    """Everything that the next event depends on, as records that the kernels change; see `kernels.motion_records`."""

    z: Array
    now: Records
    count: Records
    cycle: Array
    past: Records
    sums: Records

    @classmethod
    def empty(cls, modes: int, window: int = kn.WINDOW) -> Snapshot:
        """All numbers 0, with room for the last `window` impacts, a power of 2."""
        z, past = np.zeros((2, modes)), np.zeros(window, kn.PAST)
        return cls(z, np.zeros(1, kn.NOW), np.zeros(1, kn.COUNT), z.copy(), past, np.zeros(2, kn.SUMS))

    def copy(self) -> Snapshot:
        """Arrays of its own, to be changed."""
        return Snapshot(*map(copied, (self.z, self.now, self.count, self.cycle, self.past, self.sums)))

    @property
    def motion(self) -> kn.KernelState:
        """What the kernels change: the same memory."""
        return kn.KernelState(
            self.z, self.now[0], self.count[0], self.cycle, self.past, self.sums,
            self.now.view(np.float64), self.count.view(np.int64), self.sums.view(np.float64).reshape(2, -1),
        )  # fmt: skip

    @property
    def impacts(self) -> int:
        return int(self.count["impacts"][0])

    @property
    def time(self) -> float:
        """Of the anchor, in radians."""
        return float(self.count["period"][0]) * kn.TURN + float(self.now["phase"][0])


def copied(values: Records) -> Records:
    """A copy in one piece: NumPy copies records field by field, which takes longer than an impact."""
    return values.view(np.uint8).copy().view(values.dtype) if values.dtype.names else values.copy()


NO_LOG = kn.Log(np.empty(0, kn.EVENT), np.empty((0, 0)))  # for motions of which nothing is recorded


def begins(
    displacement: Array,
    velocity: Array,
    gap: Array,
    phase: Array,
    period: npt.NDArray[np.int64],
    piece: npt.NDArray[np.int64],
) -> kn.StartRows:
    """The starts of motions for the kernels; read-only, as numba would compile all once more for other arrays."""
    columns = kn.StartRows(displacement, velocity, gap, phase, period, piece)
    found = [np.ascontiguousarray(values).view() for values in columns]
    for values in found:
        values.setflags(write=False)
    return kn.StartRows(*found)  # type: ignore[arg-type]  # of the types that they had


def desk_for(table: kn.MotionTable) -> kn.Workspace:
    """Room to work in."""
    n = table.modes.omega.shape[-1]
    return kn.Workspace(np.zeros((2, table.harmonics.gap_re.size)), *(np.zeros(n) for _ in range(5)))


def clocks(time: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], Array]:
    """Load periods gone by at some times, and the phases in [0, 2π)."""
    times = np.asarray(time, dtype=float)
    turns = np.floor(times / kn.TURN)
    phase = np.maximum((times - turns * kn.TURN) - turns * kn.TURN_LOW, 0.0)
    over = phase >= kn.TURN
    return np.asarray(turns + over, dtype=np.int64), np.where(over, 0.0, phase)


def clock(time: float) -> tuple[int, float]:
    """The same at one time, to the last bit, in a twentieth of the time."""
    turns = math.floor(time / kn.TURN)
    phase = max((time - turns * kn.TURN) - turns * kn.TURN_LOW, 0.0)
    return (turns, phase) if phase < kn.TURN else (turns + 1, 0.0)


def begun(load: Load, time: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], Array, npt.NDArray[np.int64]]:
    """Load periods, phases and steps with which motions begin; a time within rounding of a step is where it begins."""
    periods, phases = clocks(time)
    turns, phases, pieces = load.on_steps(phases, _OFF * np.abs(time))
    return periods + turns, phases, pieces.astype(np.int64)


def begin(spectrum: Spectrum, table: kn.MotionTable, start: Start) -> Snapshot:
    """The state at the start."""
    u, v, gap = start.state(spectrum.modes, spectrum.system)
    state = Snapshot.empty(spectrum.modes)
    load = spectrum.system.load
    if load.is_piecewise:
        when = begun(load, np.array([start.time]))
    else:
        period, phase = clock(start.time)
        when = np.array([period]), np.array([phase]), np.zeros(1, dtype=np.int64)
    starts = begins(u[None], v[None], np.array([gap]), when[1], when[0], when[2])
    put_first(to_change(table), state.motion, desk_for(table), starts)
    return state


# ---- The loop around the kernels: calls them stretch by stretch, gathers the events, reports progress

_MOST_MEMORY = 1 << 30  # bytes of recorded events and states
_TOO_MANY = 64  # such strides without an impact end a simulation
ENDS = {
    kn.BY_IMPACTS: "impacts",
    kn.BY_TIME: "time",
    kn.AT_REST: "rest",
    kn.PERIODIC: "periodic",
    kn.DEPARTED: "departed",
    kn.UNRESOLVED: "unresolved",
}
"""What the kernels' ends are called."""

# of a motion that goes on by itself
_NOWHERE = begins(*np.empty((2, 0, 1)), *np.empty((2, 0)), *np.empty((2, 0), dtype=np.int64))
GOES_ON, _NO_TAIL, _ENDLESS = np.zeros(1, dtype=np.int64), np.empty((1, 0), kn.PAST), np.array([[math.inf, 0.0]])


@dataclass(frozen=True)
class Progress:
    """How far a simulation has come.

    Attributes
    ----------
    impacts
        From the start.
    time
        From the start, in radians.
    fraction
        0 to 1: of the impacts or the time asked for, whichever is nearer.
    """

    impacts: int
    time: float
    fraction: float


def gathered(
    log: kn.Log,
    count: Any,
    step: Callable[[], tuple[str, bool]],
    gone: Callable[[], tuple[int, float]],
    stop: Stop,
    progress: Callable[[Progress], object] | None,
    idle: tuple[int, bool],
) -> tuple[Events, Array, str]:
    """Calls the kernels stretch by stretch until a motion ends: its events, the states after them, and how it ended."""
    # `step`: a stretch: how the motion ended, or nothing, and whether its work is done. `gone`: impacts and time so
    # far. `idle`: stretches of work without an impact that end a motion or, where the flag is set, without any event.
    events, states, ended, still, taken, impacts = [], [], "", 0, 0, -1
    row = log.events.itemsize + log.states.itemsize * log.states.shape[1]
    while not ended:
        ended, worked = step()
        n = int(count["events"])
        count["events"], taken = 0, taken + n * row
        struck, time = gone()
        if taken > _MOST_MEMORY and not ended:
            ended = "memory"
        if worked:
            same = not n if idle[1] else struck == impacts
            still, impacts = still + 1 if same else 0, struck
            if still >= idle[0]:
                ended = "work"
        elif idle[1]:
            still = 0
        fraction = struck / max(stop.most_impacts, 1)
        if stop.time is not None:
            fraction = max(fraction, time / stop.time)
        if progress is not None and progress(Progress(struck, time, min(fraction, 1.0))) and not ended:
            ended = "interrupted"
        events.append(events_of(log.events[:n]))
        states.append(log.states[:n] if ended else log.states[:n].copy())
    return joined(events), states[0] if len(states) == 1 else np.concatenate(states), ended


def events_of(log: npt.NDArray[Any]) -> Events:
    """The kernels' events as columns, in the kernels' units."""
    columns: dict[str, Any] = {name: log[name].copy() for name in ("period", "phase", "resolved", "piece", "port")}
    return Events(
        code=log["kind"].astype(np.int8),
        impact_velocity=log["before"].copy(),
        rebound_velocity=log["after"].copy(),
        energy_lost=log["lost"].copy(),
        kinetic_energy=log["kinetic"].copy(),
        **columns,
    )


# ---- A motion on its way, and what the stretch simulated last makes of it

_ARRAYS = ("z", "now", "count", "cycle", "past", "sums")


@dataclass(frozen=True)
class Clocked:
    """A motion of a system on its way."""

    spectrum: Spectrum
    table: kn.MotionTable
    snapshot: Snapshot

    @property
    def modes(self) -> int:
        """N."""
        return self.spectrum.modes

    @classmethod
    def begun(cls, system: System, modes: int, start: Start) -> tuple[Clocked, Anchor, bool]:
        """A motion put at a start, the state there, and whether it rests on the wall."""
        spectrum, table = prepared(system, system.body.chosen(modes))
        snapshot = begin(spectrum, table, start)
        now, count = snapshot.now[0], snapshot.count[0]
        row = np.concatenate([[now["gap"], now["rigid_rate"]], snapshot.z.reshape(-1)])
        anchor = Anchor(float(now["phase"]), int(count["piece"]), row)
        return cls(spectrum, table, snapshot), anchor, int(count["mode"]) == kn.RESTING

    def followed(
        self, stop: Stop, begin_time: float, progress: Callable[[Progress], object] | None = None, skip: int = 0
    ) -> dict[str, Any]:
        """The motion on until the stop rule holds, as fields of a `Trajectory`; the sums leave out `skip` impacts."""
        table, state = self.table, self.snapshot.copy()
        modes, own, count = self.modes, to_change(table), state.count[0]
        room = max(64, min((1 << 20) // (2 * modes + 2), stop.most_impacts - state.impacts + 16, 4096))
        log = kn.Log(np.empty(room, kn.EVENT), np.empty((room, kn.STATE_NUMBERS + 2 * modes)))
        motion, twin, desk = state.motion, state.copy().motion, desk_for(table)
        if table.values.size:
            set_load(own.bar, table.values[count["piece"]])
        found, stride = np.zeros(1, kn.MEMBER), kn.STRIDE // (modes + 30)
        ends = _ENDLESS if stop.time is None else np.array([clock(begin_time + stop.time)])

        def step() -> tuple[str, bool]:
            budget = (int(count["work"]) // stride + 1) * stride
            rules = kn.Rules(np.inf, 0.0, stop.most_impacts, stop.periodic, stop.tolerance, skip, budget)
            follow(own, _NOWHERE, ends, rules, motion, twin, desk, log, NO_LOG, GOES_ON, found, _NO_TAIL)
            code = int(found["ended"][0])
            if code == kn.AT_REST and not rests(self.spectrum.system, modes):
                return self._let_go(own, state, log, ends[0]), False
            return ENDS.get(code, ""), code == kn.BY_WORK

        def gone() -> tuple[int, float]:
            return state.impacts, state.time - begin_time

        events, states, outcome = gathered(log, count, step, gone, stop, progress, (_TOO_MANY, False))
        cycle = _cycle(state.count)
        wanders = not self.spectrum.system.load.is_constant and bool(found["wanders"][0])
        end = state.time if outcome != "time" or stop.time is None else begin_time + stop.time
        return {
            "events": events,
            "states": states,
            "snapshot": {name: getattr(state, name) for name in _ARRAYS},
            "outcome": outcome,
            "label": label_of(outcome, cycle, wanders, unresolved(state.count)),
            "cycle": cycle,
            "end_time": max(end, begin_time),
        }

    def _let_go(self, own: kn.MotionTable, state: Snapshot, log: kn.Log, ends: Array) -> str:
        """A structure of several modes at rest released into the state; or how its motion ends before."""
        spectrum, now, count = self.spectrum, state.now[0], state.count[0]
        phase, piece, period = float(now["phase"]), int(count["piece"]), int(count["period"])
        shape = spectrum.unit * spectrum.modal(state.z, 0.0, 0.0, phase, spectrum.mean(piece))[0][1:]
        held, left = held_structure(spectrum.system, self.modes), (ends[0] - period) * kn.TURN + (ends[1] - phase)
        wait, piece, (place, rate) = _released(held, phase, piece, (shape, np.zeros_like(shape)), left)
        if not wait < left:
            return "rest" if wait == math.inf else "work" if math.isnan(wait) else "time"
        turns, phase = clock(phase + wait)
        if own.values.size:
            set_load(own.bar, own.values[piece])
        u, v = (np.append(0.0, one / spectrum.unit) for one in (place, rate))
        state.z[:] = spectrum.amplitudes(u, v, phase, spectrum.mean(piece))
        for name, value in (
            ("gap", 0.0), ("gap_rate", 0.0), ("rigid_rate", 0.0), ("phase", phase), ("cosine", math.cos(phase)),
            ("sine", math.sin(phase)), ("hold", _AWAY / max(1.0, float(spectrum.omega.max()))), ("last_flight", -1.0),
            ("since", 0.0), ("released", -1.0), ("last_place", 0.0),
        ):  # fmt: skip
            now[name] = value
        bounded(own.bar, own.modes, state.z, now)
        count["period"], count["piece"], count["mode"], count["run"] = period + turns, piece, kn.ON_WALL, 0
        count["release_period"], count["work"] = count["period"], count["work"] + 1
        row = log.events[count["events"]]
        row.fill(0)
        row["kind"], row["port"], row["phase"], row["period"], row["piece"] = RELEASE, -1, phase, period + turns, piece
        log.states[count["events"]] = np.concatenate([[0.0, 0.0], state.z.reshape(-1)])
        count["events"] += 1
        return ""


def _cycle(count: npt.NDArray[Any]) -> MotionCycle | None:
    """The confirmed cycle that the engine's whole numbers tell of."""
    if count["confirmed"][0] < 2:
        return None
    names = ("found_at", "cycle_impacts", "cycle_periods", "cycle_kind")
    first, impacts, periods, kind = (int(count[name][0]) for name in names)
    return MotionCycle(first - 1, impacts, periods, kind)


# ---- When a structure of several modes, whose contact the wall holds, leaves it: where the wall would have to pull

_ROUNDING = 2.0**-52
_FADED = 1e-13  # of the force: what is left of the motion that decays no longer matters
_LOOKS = 100_000  # at the force, in one rest


def _released(held: HeldStructure, phase: float, piece: int, state: Modal, until: float) -> tuple[float, int, Modal]:
    """When the wall lets go, the step of the load then, and the state; as `_lets_go`."""
    slowest = -float(held.free[0].real.max(initial=-math.inf))
    patience = -math.log(_FADED) / slowest + 2.0 * kn.TURN if slowest > 0.0 else math.inf
    for begin, length, at, motion in held.legs(phase, piece, state):
        wait = _lets_go(motion, min(length, until - begin))
        if wait < length or math.isnan(wait) or length == math.inf:
            u, v = motion.at(np.array([wait if wait < math.inf else 0.0]))
            return begin + wait, at, (u[:, 0], v[:, 0])
        if begin > patience:
            break
    return math.inf, piece, state


def _lets_go(motion: HeldMotion, until: float) -> float:
    """When the force first turns to a pull, stepped under a parabola by F″'s bound; inf: never, NaN: open."""
    exponents, (k, _) = motion.held.free[0], motion.held.waves
    swing, sizes = float(np.abs(motion.waves).sum()), np.abs(motion.fading)
    bent, curves = float((k * k * np.abs(motion.waves)).sum()), sizes * np.abs(exponents) ** 2
    least = 64.0 * _ROUNDING * (abs(motion.steady) + swing + float(sizes.sum()))
    tau, blind, known = 0.0, 1e-9, math.inf
    for _ in range(_LOOKS):
        left = np.exp(exponents.real * tau)
        remains = float(sizes @ left)
        if remains < _FADED * (abs(motion.steady) + swing) and known == math.inf:
            known = tau + kn.TURN  # from then on it repeats itself
        if motion.steady - swing > remains or tau > known:
            return math.inf
        if tau >= until:
            return until
        force, rate = (float(one[0]) for one in motion.force(np.array([tau])))
        if force < -least or (force <= least and rate < 0.0):
            return tau
        if force <= least:  # a touch
            tau, blind = tau + blind, 2.0 * blind
            continue
        root = math.sqrt(rate * rate + 2.0 * (bent + float(curves @ left)) * force)
        step = 2.0 * force / (root - rate) if root > rate else math.inf
        tau, blind = tau + max(min(step, kn.TURN), _ROUNDING * max(tau, 1.0)), 1e-9
    return math.nan
