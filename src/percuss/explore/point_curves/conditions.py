"""What makes an orbit a grazing, a corner …: one equation more than its unknowns, smooth along a curve of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.orbit_curve import OrbitProblem, step_of, steps_passed
from percuss.explore.continuation.problem import CorrectorFailed, CurvePoint
from percuss.explore.family import Family
from percuss.model import System
from percuss.model.checks import Array, ComplexArray
from percuss.steady import PeriodicOrbit

_LATE = 1e-4  # rad, by which the acceleration of the end is asked for


class Condition(ABC):
    """What is asked of an orbit, besides that it is one; by default of its times as they are, the same all along."""

    @property
    @abstractmethod
    def kind(self) -> BranchEvent:
        """What the orbit is where it holds."""

    @abstractmethod
    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """By how much it does not hold; as many numbers as it brings unknowns, and one."""

    def placed(self, system: System, times: Array) -> Array:
        """The times of the impacts as they stand in the equations."""
        return times

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Condition:
        """The same with what belongs to a place on the curve taken anew there."""
        return self


@dataclass(frozen=True)
class Death(Condition):
    """An impact without speed: number `which`."""

    which: int
    kind = BranchEvent.DEATH

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        return np.array([orbit.speeds[self.which]])


@dataclass(frozen=True)
class Touch(Condition):
    """The bar touches the wall in flight `flight`, at a time after its start that is an unknown."""

    flight: int
    kind = BranchEvent.TOUCH

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        y, velocity = orbit.flights[self.flight].end_motion(extra, orbit.modes)
        return np.array([y[0], velocity[0]])


@dataclass(frozen=True)
class Corner(Condition):
    """Impact `which` falls on step `number` of the load, counted from time 0 on.

    The impact is put on the step before anything else is computed, so that the step may move with the parameters: as a
    function of the times alone the equations have a corner there.
    """

    which: int
    number: int
    kind = BranchEvent.CORNER

    @staticmethod
    def of(orbit: PeriodicOrbit, which: int) -> Corner:
        """The step that an impact of an orbit is at."""
        if not orbit.system.load.breaks:
            raise ParameterError("point", str(orbit), "an orbit whose load has steps")
        last = int(steps_passed(orbit)[which])
        numbers = (last - 1, last)
        return Corner(which, min(numbers, key=lambda n: abs(step_of(orbit.system, n) - orbit.times[which])))

    def placed(self, system: System, times: Array) -> Array:
        found = np.array(times)
        found[self.which] = step_of(system, self.number)
        return found

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        return np.array([times[self.which] - orbit.times[self.which]])


def curvature(orbit: PeriodicOrbit, condition: Condition, extra: Array) -> float:
    """The acceleration of the striking end where it grazes, just after: negative where it really does."""
    if isinstance(condition, Touch):
        flight, time = orbit.flights[condition.flight], float(extra[0])
        velocity = flight.end_motion(np.array([time - _LATE, time + _LATE]), orbit.modes)[1]
        return float(velocity[1] - velocity[0]) / (2.0 * _LATE)
    assert isinstance(condition, Death)
    flight = orbit.flights[condition.which]
    velocity = flight.end_motion(np.array([0.0, _LATE]), orbit.modes)[1]
    return float(velocity[1] - velocity[0]) / _LATE


# ---- What makes an orbit a fold, a flip or a Neimark–Sacker point: a multiplier, or a pair, on the unit circle
#
# A multiplier ξ makes K(ξ) singular. Bordered by a column b and a row cᵀ, [K b; cᵀ 0](v, g) = (0, 1), it is not, and
# g vanishes where det K(ξ) does, of whatever size the determinant is (Griewank & Reddien, IMA J. Numer. Anal. 4 (1984)
# 295–303; Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, 2000, ch. 3).

_NARROW, _ROUND = 5e-7, 2e-6  # of cos θ from ±1, nearer than which what is asked is its mean on a circle around
_VANISHED = 1e-6  # of the longest row: a row that is 0 has no length of its own


@dataclass(frozen=True)
class Multiplier(Condition):
    """A multiplier ξ = 1, a fold, or −1, a flip.

    `border` is the left and the right singular vector of K(ξ) with its rows taken by their lengths, and these.
    """

    xi: float
    border: tuple[Array, Array, Array]

    @staticmethod
    def of(orbit: PeriodicOrbit, xi: float) -> Multiplier:
        """With the borders of an orbit."""
        return Multiplier(xi, _border(orbit.bordered(xi)))

    @property
    def kind(self) -> BranchEvent:
        return BranchEvent.FOLD if self.xi > 0.0 else BranchEvent.FLIP

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        return np.array([self.at(orbit, self.xi).real])

    def at(self, orbit: PeriodicOrbit, xi: complex) -> complex:
        """g of another number in place of ξ, with the same borders."""
        return _bordered(orbit.bordered(xi), self.border)

    def null(self, orbit: PeriodicOrbit) -> Array:
        """v, by which the unknowns of the orbit change along the other branch; shape (p + 1,)."""
        return np.asarray(np.linalg.svd(orbit.bordered(self.xi).real)[2][-1])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Multiplier:
        return Multiplier.of(orbit, self.xi)


@dataclass(frozen=True)
class Pair(Condition):
    """A pair of multipliers on the unit circle; cos θ is an unknown.

    g(ξ) + g(1/ξ) and (g(ξ) − g(1/ξ))/(ξ − 1/ξ) are real and smooth where the two meet at 1 or at −1, too.
    """

    border: tuple[Array, Array, Array]
    kind = BranchEvent.NEIMARK_SACKER

    @staticmethod
    def of(orbit: PeriodicOrbit, cosine: float) -> Pair:
        """With the borders of an orbit."""
        return Pair(_border(orbit.bordered(_on_circle(cosine))))

    def off(self, orbit: PeriodicOrbit, times: Array, extra: Array) -> Array:
        """Mean and difference quotient of g at ξ and 1/ξ; both are analytic in cos θ, also where ξ = 1/ξ."""
        cosine = float(extra[0])
        if abs(abs(cosine) - 1.0) > _NARROW:
            return self._halves(orbit, cosine).real
        ahead, behind, aside = (self._halves(orbit, cosine + _ROUND * way) for way in (1.0, -1.0, 1j))
        return 0.25 * (ahead + behind + 2.0 * aside).real  # with the conjugate of the last: exact to the third order

    def _halves(self, orbit: PeriodicOrbit, cosine: complex) -> ComplexArray:
        xi = _on_circle(cosine)
        first = _bordered(orbit.bordered(_plain(xi)), self.border)
        if isinstance(cosine, float) and abs(cosine) < 1.0:
            return np.array([first.real, first.imag / xi.imag], dtype=complex)
        second = _bordered(orbit.bordered(_plain(1.0 / xi)), self.border)
        return np.array([0.5 * (first + second), (first - second) / (xi - 1.0 / xi)])

    def renewed(self, orbit: PeriodicOrbit, extra: Array) -> Pair:
        return Pair.of(orbit, float(extra[0]))


def _border(matrix: Array | ComplexArray) -> tuple[Array, Array, Array]:
    """Real borders and the lengths of the rows; the longest for one that vanishes, as of a held body."""
    lengths = np.linalg.norm(matrix, axis=1)
    lengths = np.where(lengths > _VANISHED * lengths.max(), lengths, lengths.max())
    left, _, right = np.linalg.svd(matrix / lengths[:, None])
    return _real(left[:, -1]), _real(right[-1].conj()), lengths


def _real(vector: ComplexArray) -> Array:
    """The longest real part of a complex vector times a number of modulus 1, of length 1."""
    square = complex(np.sum(vector**2))
    turned = vector * np.exp(-0.5j * np.angle(square)) if square else vector
    return np.asarray(turned.real / np.linalg.norm(turned.real))


def _bordered(matrix: Array | ComplexArray, border: tuple[Array, Array, Array]) -> complex:
    column, row, lengths = border
    size = row.size
    whole = np.zeros((size + 1, size + 1), dtype=matrix.dtype)
    whole[:size, :size], whole[:size, size], whole[size, :size] = matrix / lengths[:, None], column, row
    try:
        return complex(np.linalg.solve(whole, np.append(np.zeros(size), 1.0))[-1])
    except np.linalg.LinAlgError:
        return complex(np.nan)


def _plain(number: complex) -> complex:
    """A number as a real one, where it is."""
    return number if number.imag else number.real


def _on_circle(cosine: complex) -> complex:
    """ξ with (ξ + 1/ξ)/2 equal to a cosine; real for one beyond 1."""
    return complex(cosine + np.sqrt(complex(cosine * cosine - 1.0)))


# ---- The orbits over two parameters for which a condition holds: its unknowns come last, and its equations

_MOST_STEPS = 16
_CLOSE = 1e-9  # after a step below this, with the derivatives of the place, there is none
_LONGEST = 0.5  # rad


@dataclass(frozen=True)
class ExtendedCurve(OrbitProblem):
    """All orbits z=p/n of a family over two parameters for which a condition holds."""

    family: Family
    names: tuple[str, ...]
    units: tuple[float, ...]
    impacts: int
    periods: int
    modes: int
    condition: Condition

    def renewed(self, x: Array) -> ExtendedCurve:
        """The same curve with what belongs to a place on it taken anew."""
        condition = self.condition.renewed(self.motion(x), self.extra(x))
        return self if condition is self.condition else self.of(condition)

    def of(self, condition: Condition) -> ExtendedCurve:
        """The curve of another condition, of the same systems."""
        made = replace(self, condition=condition)
        made.__dict__["_systems"] = self._systems
        return made

    def extra(self, x: Array) -> Array:
        """The unknowns of the condition."""
        return x[self.impacts + 3 :]

    def placed(self, system: System, times: Array) -> Array:
        return self.condition.placed(system, times)

    def residual(self, x: Array) -> Array:
        orbit = self.motion(x)
        return np.append(orbit.residuals, self.condition.off(orbit, x[: self.impacts], self.extra(x)))

    def settled(self, start: Array) -> CurvePoint:
        """The nearest point of the curve, with a tangent either way; or CorrectorFailed."""
        x = np.array(start)
        try:
            for step in range(1, _MOST_STEPS + 1):
                matrix = self.matrix(x)
                moved = -np.linalg.pinv(matrix) @ self.residual(x)
                if not float(np.abs(moved).max()) <= _LONGEST:
                    break
                x = x + moved
                if float(np.abs(moved).max()) <= _CLOSE:
                    if self.refusal(*self.values(x)) is not None:  # by rounding, where a parameter begins
                        x[self.impacts + 1 : self.impacts + 3] = start[self.impacts + 1 : self.impacts + 3]
                    return CurvePoint(x, np.linalg.svd(matrix)[2][-1], step, matrix)
        except (PercussError, np.linalg.LinAlgError) as error:
            raise CorrectorFailed(str(error)) from None
        raise CorrectorFailed("no convergence")
