"""A periodic motion of an elastic machine that switches its own valve, and its figures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from percuss.model import Machine
from percuss.model.checks import Array, ComplexArray
from percuss.shown import Shown
from percuss.steady.self_excited.elastic_chain import place_row
from percuss.steady.self_excited.first_entering import farthest
from percuss.steady.self_excited.modal_flight import ModalFlight
from percuss.steady.self_excited.piston_records import Switch, Uncovering
from percuss.steady.self_excited.rhythm import Rhythm
from percuss.steady.self_excited.ringing import Parted, Ringing, parted
from percuss.steady.self_excited.valve_cycle import Place, ValveCycle

__all__ = ["Blow", "ElasticCycle"]


@dataclass(frozen=True)
class Blow(Shown):
    """A blow of an elastic machine.

    Attributes
    ----------
    time, speed
        When, and the speed of the striking end just before.
    kinetic, strain
        Energies just before, per unit of mass; that of the chamber, which follows the driven end, is part of `strain`.
    """

    time: float
    speed: float
    kinetic: float
    strain: float


@dataclass(frozen=True)
class ElasticCycle(ValveCycle):
    """A periodic motion of an elastic machine that switches its own valve.

    Parameters
    ----------
    machine, modes
        The machine, and N.
    flights
        The stretches between events, in order of time.
    struck
        The blows.
    changed, passed
        Changes of the valve's state, with place and velocity of the driven end; passages of ports that demand.
    slope
        Derivative of the map from cycle to cycle: of displacement and velocity of every coordinate, one coordinate
        after the other, and of the times of the pending orders.
    rhythm
        When it strikes and passes ports, and the valve at time 0.
    lies
        Whether the striking end lies on the wall for some time.
    given_up
        Energy that the bar has where it lies down.
    """

    machine: Machine
    modes: int
    flights: tuple[ModalFlight, ...]
    struck: tuple[Blow, ...]
    changed: tuple[Switch, ...]
    passed: tuple[Uncovering, ...]
    slope: Array
    rhythm: Rhythm
    lies: bool = False
    given_up: float = 0.0

    @property
    def blow_times(self) -> Array:
        """When the blows fall, the last one at the period."""
        return np.array([blow.time for blow in self.struck])

    @property
    def blow_speeds(self) -> Array:
        """Speed of the striking end just before each blow."""
        return np.array([blow.speed for blow in self.struck])

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy just before each blow, that of the ringing with it."""
        return np.array([blow.kinetic for blow in self.struck])

    @property
    def switches(self) -> tuple[Switch, ...]:
        """Every change of the valve's state, in order of time."""
        return self.changed

    @property
    def uncoverings(self) -> tuple[Uncovering, ...]:
        """Where ports demand a new state, in order of time; blows that do are not among them."""
        return self.passed

    @cached_property
    def multipliers(self) -> ComplexArray:
        """Multipliers of the map from cycle to cycle, the greatest first, without the neutral one, a shift in time."""
        found: ComplexArray = np.linalg.eigvals(self.slope).astype(complex)
        return found[np.argsort(-np.abs(found), kind="stable")]

    @property
    def rhythm_multiplier(self) -> complex | None:
        """The greatest multiplier of the motion as a whole; None where it cannot be told from the ringing."""
        return self._parted.rhythm

    @property
    def ringing(self) -> Ringing | None:
        """What rings longest; None where nothing is left of the ringing after a cycle."""
        return self._parted.ringing

    @cached_property
    def _parted(self) -> Parted:
        return parted(self.slope, self.modes)

    @property
    def rests(self) -> bool:
        """Whether the striking end lies on the wall for some time."""
        return self.lies

    @cached_property
    def stroke(self) -> float:
        """The greatest distance of the striking end from the wall."""
        row = self.flights[0].modes.end
        return max((farthest(flight, row) for flight in self.flights if flight.duration > 0.0), default=0.0)

    @property
    def level_difference(self) -> float:
        """The greatest force of the valve minus the least."""
        forces = [force for _, force in self.machine.valve.pairs]
        return max(forces) - min(forces)

    @cached_property
    def work(self) -> float:
        """Energy that the valve puts in in a cycle: its force over the way of the driven end in flight.

        The constant part of the chamber's force is in it: without a rest or a blow that turns the strain over, in which
        the driven end moves in no time, its work is none.
        """
        driven = self.flights[0].modes.driven
        return math.fsum(one.force * float((one.end - one.begin)[:, 0] @ driven) for one in self.flights)

    @property
    def taken(self) -> float:
        """Energy that the blows of a cycle take."""
        return math.fsum(self.machine.contact.energy_taken(blow.kinetic, blow.strain) for blow in self.struck)

    @property
    def taken_by_rest(self) -> float:
        """Energy lost on lying down: what the last blow left, for a bar at rest on the wall is undeformed."""
        return self.given_up

    def _displacement(self, within: Array, place: Place) -> Array:
        row = place_row(self.machine, self.flights[0].modes, place)
        begins = np.array([flight.time for flight in self.flights])
        which = np.maximum(np.searchsorted(begins, within, side="right") - 1, 0)
        found = np.empty(within.shape)
        for number, flight in enumerate(self.flights):
            mine = which == number
            if mine.any():
                found[mine] = row @ flight.at(within[mine] - flight.time)[0]
        return found
