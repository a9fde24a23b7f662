"""The numbers of one system as the kernels want them, computed once for all its motions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model import Kept, Load, System
from percuss.model.body import Body
from percuss.model.checks import Array
from percuss.simulate.kernels.clock import release_phases
from percuss.simulate.kernels.motion import place
from percuss.simulate.kernels.motion_records import (
    BAR,
    COUNT,
    EVENT,
    NOW,
    PAST,
    POWERS,
    RATIO,
    SINGLY,
    SUMS,
    TURN,
    TURN_LOW,
    WINDOW,
    Desk,
    Harmonics,
    Log,
    Modes,
    Motion,
    Starts,
    Table,
)
from percuss.simulate.spectrum import DampedModes, Spectrum, held_table, shifted
from percuss.simulate.start import Start

_EQUAL = 4.0 * np.finfo(float).eps


@lru_cache(maxsize=16)
def prepared(system: System, modes: int) -> tuple[Spectrum, Table]:
    """Spectrum and table of a system, kept for the next motion of it.

    Raises
    ------
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).
    """
    return Spectrum(system, modes), table_of(system, modes)


def table_of(system: System, modes: int) -> Table:
    """The kernels' table of a system cut at mode N; its `bar` is the caller's own, which the kernels change.

    Its neighbours in a map, with another restitution or mean load, share all but a few numbers of it.

    Raises
    ------
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).
    """
    load = system.load
    harmonics = () if load.is_piecewise else tuple(load.coefficients.tolist())[1:]
    shared = _without_mean(system.body, load.at, harmonics, modes)
    bar = _copied(shared.bar)
    bar["restitution"], bar["strain"] = -system.contact.velocity_factor, system.contact.strain_factor
    bar["mean"], bar["pushing"] = load.mean, _longest_push(load)
    if not system.body.is_free:
        return held_table(shared._replace(bar=bar), system)
    if load.is_piecewise:
        steps = np.array(load.values)
        bar["force"] = float(np.abs(load.values).max())
        releases = np.array(load.breaks)[(steps < 0.0) & (np.roll(steps, 1) >= 0.0)]
        return shared._replace(bar=bar, breaks=np.array(load.breaks), values=steps, releases=releases)
    bar["force"] = abs(load.mean) + shared.bar["force"]
    return shared._replace(bar=bar, releases=_releases(system.body, load.at, harmonics, modes, load.mean))


def to_change(table: Table) -> Table:
    """A table with a `bar` of its own, which the kernels change."""
    return table._replace(bar=_copied(table.bar))


def _copied(bar: np.void) -> np.void:
    """A copy in one piece: `copy` takes an impact's time for each field, and `np.array` shares the memory."""
    found: np.void = np.ndarray(1, BAR, bytearray(bar.tobytes()))[0]
    return found


@lru_cache(maxsize=16)
def _without_mean(body: Body, at: int, harmonics: tuple[complex, ...], modes: int) -> Table:
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
    return Table(
        bar,
        tabled_modes(spectrum, bar),
        Harmonics(*(np.array(part, order="C") for part in parts)),
        coupling,
        none,
        none,
        none,
    )


def bar_of(body: Body, modes: DampedModes) -> np.void:
    """The numbers of a bar that do not depend on its load; all others are 0."""
    bar: np.void = np.zeros(1, BAR)[0]
    bar["damping"], bar["whole"], bar["ripple"] = body.rigid_drag, 1.0, 1e-3
    if modes.omega.size:
        bar["wave"] = (1.0 + 0.5 / modes.omega.size) * body.transit_time
        bar["ripple"] = 0.5 * np.pi / modes.omega[-1]
    bar["contact"] = 2.0 * body.transit_time
    return bar


def tabled_modes(spectrum: DampedModes, bar: np.void) -> Modes:
    """The elastic modes, and what `bar` says of all of them."""
    omega, damping, creeps = spectrum.omega.copy(), spectrum.damping.copy(), spectrum.creeps
    oscillates, half = np.where(creeps, 0.0, 1.0), 0.5 * damping
    lam = spectrum.lam
    delta = np.zeros(omega.size)
    bar["law"] = law = _law(omega, damping, creeps)
    own = half[~creeps]
    if omega.size:
        bar["quickest"], bar["base"] = omega.max(), omega[0] if law == POWERS else lam[0]
        rates = half.copy()
        rates[creeps] = np.minimum(half, omega * omega / np.where(creeps, damping, 1.0))[creeps]  # d/2 − κ ≥ ω²/d
        bar["linger"] = rates.min()
    if law == POWERS and omega.size:
        bar["half"] = half[0]
        delta = oscillates * half * half / (omega + lam)
        bar["delta"] = delta.max()
    elif law == RATIO:
        bar["base_half"] = half[0]
    bar["wane"], slowest = (2.0 * own.max(), 2.0 * own.min()) if own.size else (0.0, np.inf)
    bar["lasting"] = 2.0 / slowest if slowest > 1e-300 else np.inf
    return Modes(
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


def _law(omega: Array, damping: Array, creeps: npt.NDArray[np.bool_]) -> int:
    """How the phasors of the modes are computed best, see `percuss.simulate.kernels.motion_records`."""
    if not omega.size:
        return POWERS
    number = np.arange(1.0, omega.size + 1.0)
    if np.any(np.abs(omega - number * omega[0]) > _EQUAL * omega):
        return SINGLY
    if np.all(damping == damping[0]):
        return POWERS
    ratio = np.all(np.abs(damping - number * damping[0]) <= _EQUAL * damping)
    return RATIO if ratio and not creeps.any() else SINGLY


_SAMPLES = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)


@lru_cache(maxsize=1024)
def _longest_push(load: Load) -> float:
    """A bound, from above, of the time for which the load does not pull; inf when no sample of it does."""
    pulls = np.flatnonzero(load.value(_SAMPLES) < 0.0)
    if not pulls.size:
        return np.inf
    return float(np.diff(pulls, append=pulls[0] + _SAMPLES.size).max() * _SAMPLES[1])


def turns_to_pull(body: Body, load: Load) -> Array:
    """Phases at which a load that is a Fourier series begins to pull, ascending."""
    return _releases(body, load.at, tuple(load.coefficients.tolist())[1:], 1, load.mean)


@lru_cache(maxsize=1024)
def _releases(body: Body, at: int, harmonics: tuple[complex, ...], modes: int, mean: float) -> Array:
    """Phases at which a Fourier series begins to pull."""
    shared = _without_mean(body, at, harmonics, modes)
    found = np.empty(shared.harmonics.gap_re.size)
    force = abs(mean) + float(shared.bar["force"])
    return np.unique(found[: release_phases(shared.harmonics, mean, float(shared.bar["bend"]), force, found)])


# ---- The whole state of a simulation between two events, as the records that the kernels change

Records = npt.NDArray[Any]

_ROUNDING = 8.0 * np.finfo(float).eps  # of a time: a few products and its own last digit


@dataclass(frozen=True)
class Snapshot:
    """Everything that the next event depends on; `percuss.simulate.kernels.motion_records` describes the records.

    Attributes
    ----------
    z
        Amplitudes of the free motion, shape (2, N).
    now, count
        Numbers and whole numbers of the anchor: one NOW and one COUNT, each of shape (1,).
    cycle
        Amplitudes of the state that later ones are compared with, shape (2, N).
    past
        The last impacts, PASTs.
    sums
        The running statistics, two SUMS.
    """

    z: Array
    now: Records
    count: Records
    cycle: Array
    past: Records
    sums: Records

    @classmethod
    def empty(cls, modes: int, window: int = WINDOW) -> Snapshot:
        """All numbers 0, with room for the last `window` impacts, a power of 2."""
        z, past = np.zeros((2, modes)), np.zeros(window, PAST)
        return cls(z, np.zeros(1, NOW), np.zeros(1, COUNT), z.copy(), past, np.zeros(2, SUMS))

    def copy(self) -> Snapshot:
        """Arrays of its own, to be changed."""
        return Snapshot(*map(_copied_record, (self.z, self.now, self.count, self.cycle, self.past, self.sums)))

    @property
    def motion(self) -> Motion:
        """What the kernels change: the same memory."""
        return Motion(
            self.z, self.now[0], self.count[0], self.cycle, self.past, self.sums,
            self.now.view(np.float64), self.count.view(np.int64), self.sums.view(np.float64).reshape(2, -1),
        )  # fmt: skip

    @property
    def impacts(self) -> int:
        """Impacts from the start."""
        return int(self.count["impacts"][0])

    @property
    def time(self) -> float:
        """Of the anchor, in radians."""
        return float(self.count["period"][0]) * TURN + float(self.now["phase"][0])


def _copied_record(values: Records) -> Records:
    """A copy in one piece: NumPy copies records field by field, which takes longer than an impact."""
    return values.view(np.uint8).copy().view(values.dtype) if values.dtype.names else values.copy()


NO_LOG = Log(np.empty(0, EVENT), np.empty((0, 0)))
"""For motions of which nothing is recorded."""


def begins(
    displacement: Array,
    velocity: Array,
    gap: Array,
    phase: Array,
    period: npt.NDArray[np.int64],
    piece: npt.NDArray[np.int64],
) -> Starts:
    """The starts of motions for the kernels; read-only, as numba would compile all once more for other arrays."""
    columns = Starts(displacement, velocity, gap, phase, period, piece)
    found = [np.ascontiguousarray(values).view() for values in columns]
    for values in found:
        values.setflags(write=False)
    return Starts(*found)  # type: ignore[arg-type]  # of the types that they had


def desk_for(table: Table) -> Desk:
    """Room to work in."""
    n = table.modes.omega.size
    return Desk(np.zeros((2, table.harmonics.gap_re.size)), *(np.zeros(n) for _ in range(5)))


def clocks(time: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], Array]:
    """Load periods gone by at some times, and the phases in [0, 2π)."""
    times = np.asarray(time, dtype=float)
    turns = np.floor(times / TURN)
    phase = np.maximum((times - turns * TURN) - turns * TURN_LOW, 0.0)
    over = phase >= TURN
    return np.asarray(turns + over, dtype=np.int64), np.where(over, 0.0, phase)


def clock(time: float) -> tuple[int, float]:
    """The same at one time, to the last bit, in a twentieth of the time."""
    turns = math.floor(time / TURN)
    phase = max((time - turns * TURN) - turns * TURN_LOW, 0.0)
    return (turns, phase) if phase < TURN else (turns + 1, 0.0)


def begun(load: Load, time: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], Array, npt.NDArray[np.int64]]:
    """Load periods, phases and steps with which motions begin; a time within rounding of a step is where it begins."""
    periods, phases = clocks(time)
    if not load.is_piecewise:
        return periods, phases, np.zeros_like(periods)
    turns, phases, pieces = load.on_steps(phases, _ROUNDING * np.abs(time))
    return periods + turns, phases, pieces.astype(np.int64)


def begin(spectrum: Spectrum, table: Table, start: Start) -> Snapshot:
    """The state at the start."""
    u, v, gap = start.state(spectrum.modes, spectrum.system)
    state = Snapshot.empty(spectrum.modes)
    period, phase, piece = begun(spectrum.system.load, np.array([start.time]))
    if not spectrum.system.body.is_free and gap == 0.0 and not u[1:].any() and not v.any():
        gap = -np.finfo(float).tiny  # else the kernels would take it for a bar at rest on the wall
    starts = begins(
        shifted(spectrum.system, spectrum.modes, u[None]),
        v[None],
        np.array([gap]),
        phase,
        period,
        piece,
    )
    place(to_change(table), state.motion, desk_for(table), starts)
    return state
