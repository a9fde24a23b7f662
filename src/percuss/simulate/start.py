"""Where a motion starts: the displacement and the velocity of the bar, and the phase of the load."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import HeldBody, System
from percuss.model.body import UniformBar
from percuss.model.checks import Array, count, finite, having, instance
from percuss.simulate.drawn import DEFAULT_RANDOM_MODES, drawn
from percuss.simulate.held import state_of
from percuss.simulate.profile import Profile, modal_parts, number_tuple, sampled, values_at
from percuss.simulate.spectrum import units

__all__ = ["Start"]

MOST = 1e12
"""The largest load phase, displacement and velocity of a start: beyond, no digit of an impact's phase is left."""

_NOISE = 1e-12  # a gap this small, relative to the displacements, is a bar on the wall


class ModalImpact(Protocol):
    """The elastic modes of a steady motion at its impact."""

    @property
    def rebound(self) -> Array: ...
    @property
    def z_velocity(self) -> Array: ...
    @property
    def forced_velocity(self) -> Array: ...


class ModalOrbit(Protocol):
    """What a start needs of a steady motion; an `Orbit` has it."""

    @property
    def system(self) -> System: ...
    @property
    def phase(self) -> float: ...
    @property
    def rigid_velocity(self) -> float: ...
    def modal_state(self, modes: int) -> ModalImpact: ...


@dataclass(frozen=True)
class Start:
    """The start of a motion. Make one with `rigid`, `modal`, `field` or `orbit`.

    Parameters
    ----------
    displacement, velocity
        u_n and u_n', n = 0, 1, …, of shape (n,), dimensionless; what a simulation has more of modes is 0.
        `u(x) = u_0 + Σ φ_n(x) φ_n(x_p) u_n`, B77's u_n: `u_0 + 2 Σ u_n cos nπx` on a uniform bar driven at its end.
    time
        Load phase (rad) at which the motion starts; any number, the clock of the events counts on from it.
    gap
        u(1), the place of the striking end; None takes it from the modes that the simulation keeps.
    source
        A steady motion that gives the state, which is then added to `displacement` and `velocity`.
    profile
        Displacement and velocity along the bar, in place of their modes.

    Raises
    ------
    ParameterError
        For numbers that are not finite or arrays of different lengths.

    Examples
    --------
    >>> Start.rigid(position=-1.0, time=0.3)
    Start.rigid(position=-1.0, velocity=0.0, time=0.3)
    """

    displacement: tuple[float, ...] = (0.0,)
    velocity: tuple[float, ...] = (0.0,)
    time: float = 0.0
    gap: float | None = None
    source: ModalOrbit | None = None
    profile: tuple[Profile, Profile] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", finite("time", self.time))
        if abs(self.time) > MOST:
            raise ParameterError("time", self.time, f"a load phase of at most {MOST:g} radians")
        for name in ("displacement", "velocity"):
            values = number_tuple(name, getattr(self, name))
            if max(map(abs, values)) > MOST:
                raise ParameterError(name, max(values, key=abs), f"numbers of at most {MOST:g}")
            object.__setattr__(self, name, values)
        if self.source is not None:
            having("source", self.source, ("modal_state", "phase", "system"), "a steady motion, or None")
        if self.profile is not None and not (isinstance(self.profile, tuple) and len(self.profile) == 2):
            raise ParameterError("profile", self.profile, "displacement and velocity along the bar: see Start.field")
        if self.gap is not None:
            object.__setattr__(self, "gap", _not_beyond(finite("position", self.gap)))

    # -- ways to make one --

    @classmethod
    def rigid(cls, position: float = -1.0, velocity: float = 0.0, time: float = 0.0) -> Start:
        """An undeformed bar at `position` ≤ 0, all of it with one velocity.

        A body that is held is bent by a force at its contact until this is at `position`, and moves in that shape.

        Parameters
        ----------
        position, velocity
            Of the bar; dimensionless (lengths of the bar, and those per radian). The wall is at 0.
        time
            Load phase in radians.
        """
        place = _not_beyond(finite("position", position))
        return cls((place,), (finite("velocity", velocity),), time, gap=place)

    @classmethod
    def modal(cls, displacement: npt.ArrayLike, velocity: npt.ArrayLike | None = None, time: float = 0.0) -> Start:
        """Full modal vectors u_n and u_n', n = 0 … N."""
        u = number_tuple("modal_displacement", displacement)
        v = (0.0,) * len(u) if velocity is None else number_tuple("modal_velocity", velocity)
        if len(u) != len(v):
            raise ParameterError("modal_velocity", f"{len(v)} numbers", f"as many as modal_displacement: {len(u)}")
        return cls(u, v, time)

    @classmethod
    def field(cls, displacement: Profile, velocity: Profile = 0.0, time: float = 0.0) -> Start:
        """Displacement u(x) and velocity u_t(x) along the bar, x = 0 at the driven and 1 at the striking end.

        Parameters
        ----------
        displacement, velocity
            A function of an array of x, or values at equal steps from x = 0 to 1 (straight between them), or a number.
            The place u(1) of the striking end is kept whatever the number of modes.
        time
            Load phase in radians.
        """
        profile = (sampled("displacement", displacement), sampled("velocity", velocity))
        # a wrong velocity is told of here, too
        end, _ = (float(values_at(part, np.array([1.0]))[0]) for part in profile)
        return cls(time=time, gap=finite("displacement(1)", end), profile=profile)

    @classmethod
    def orbit(cls, orbit: ModalOrbit, displacement: npt.ArrayLike = (0.0,), velocity: npt.ArrayLike = (0.0,)) -> Start:
        """Just after the impact of a steady motion, plus a perturbation of u_n and u_n', n = 0, 1, …

        A perturbation of displacement moves the striking end off the wall: it must not move it beyond.
        """
        having(
            "orbit", orbit, ("modal_state", "system"), "a steady motion, such as one of steady_states(system).orbits"
        )
        du, dv = number_tuple("displacement", displacement), number_tuple("velocity", velocity)
        return cls(du, dv, float(orbit.phase), source=orbit)

    @classmethod
    def random(
        cls, system: System, seed: int = 0, distribution: str = "rigid", modes: int = DEFAULT_RANDOM_MODES
    ) -> Start:
        """One start drawn from a named distribution; see `Starts.random`."""
        u, v, gap, time = drawn(system, 1, seed, distribution, modes)
        return cls(tuple(u[0].tolist()), tuple(v[0].tolist()), float(time[0]), gap=float(gap[0]))

    # -- the state --

    def at(self, time: float) -> Start:
        """The same state at another phase of the load."""
        return replace(self, time=time)

    def state(self, modes: int, system: System | None = None) -> tuple[Array, Array, float]:
        """u_n and u_n', n = 0 … `modes`, each of shape (modes+1,), and the gap y = u(1) ≤ 0.

        Parameters
        ----------
        modes
            N.
        system
            Whose modes they are; those of a uniform bar, driven at its end, by default.

        Raises
        ------
        ParameterError
            When the start has more modes than `modes`, or the striking end stands beyond the wall.
        """
        size = count("modes", modes, least=0, most=1 << 20) + 1
        if system is not None:
            instance("system", system, System)
        u, v = np.zeros(size), np.zeros(size)
        for name, given, into in (("displacement", self.displacement, u), ("velocity", self.velocity, v)):
            if self.gap is None and len(given) > size and any(given[size:]):
                raise ParameterError(
                    f"modal_{name}", f"{len(given)} numbers", f"at most {size} (modes 0 to {modes})", "use more modes"
                )
            into[: min(len(given), size)] = given[:size]
        body, place = (UniformBar(1.0), 0) if system is None else (system.body, system.load.at)
        elastic = body.modes(modes, place)
        unit = units(elastic)
        if isinstance(body, HeldBody) and self.source is None:
            return self._of_structure(body, place, modes, unit, u, v)
        if self.profile is not None:
            u, v = (modal_parts(profile, body, unit) for profile in self.profile)
        if self.source is not None:
            at = self.source.modal_state(size - 1)
            driven = elastic.gamma / unit  # 1, and next to nothing where the load acts at a node of the mode
            v[1:] += (at.z_velocity + at.forced_velocity) * driven
            v[0] += self.source.system.contact.velocity_factor * self.source.rigid_velocity
            moved = float(u[0] + unit @ u[1:])
            u[1:] += at.rebound * driven
            if isinstance(body, HeldBody):  # on the wall of this system, which may stand elsewhere
                u[1:] += (body.gap - self.source.system.body.gap) * body.bent(modes, place) * driven
            u[0] = moved - float(unit @ u[1:])
            return u, v, _on_wall(moved, float(np.abs(u).max()))
        gap = float(u[0] + unit @ u[1:]) if self.gap is None else self.gap
        gap = _on_wall(gap, float(np.abs(u).max()))
        u[0] = gap - float(unit @ u[1:])
        return u, v, gap

    def _of_structure(
        self, body: HeldBody, at: int, modes: int, unit: Array, u: Array, v: Array
    ) -> tuple[Array, Array, float]:
        """`state` of a body that is held, of which u_0 is −g whatever is given."""
        if self.profile is not None:
            raise ParameterError("displacement", "along a bar", "a start of modes for a body that is held")
        given = len(self.displacement) > 1 or self.gap is None
        gap = self.gap if self.gap is not None else float(unit @ u[1:]) - body.gap
        gap = _on_wall(gap, float(np.abs(u).max()) + abs(body.gap))
        rows = (u[None], v[None]) if given else (u[None, :1], v[None, :1])
        u_rows, v_rows = state_of(body, at, modes, *rows, np.array([gap]))
        return u_rows[0], v_rows[0], gap

    def __repr__(self) -> str:
        if self.profile is not None:
            return f"Start.field(…, time={self.time!r})"
        if self.source is not None:
            return f"Start.orbit({self.source}, …)"
        if len(self.displacement) == 1:
            return f"Start.rigid(position={self.displacement[0]!r}, velocity={self.velocity[0]!r}, time={self.time!r})"
        return f"Start.modal({len(self.displacement)} modes, time={self.time!r})"


def _not_beyond(position: float) -> float:
    if position > 0.0:
        raise ParameterError("position", position, "0 (on the wall) or less", "the bar is on the negative side")
    return position


def _on_wall(gap: float, size: float) -> float:
    """The gap, and 0 for what is rounding of it."""
    if abs(gap) <= _NOISE * size:
        return 0.0
    if gap > 0.0:
        raise ParameterError("gap", gap, "a striking end at or before the wall, u(1) ≤ 0", "lower u_0")
    return gap
