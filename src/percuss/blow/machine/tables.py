"""A system and what it strikes as the records of the compiled room."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from percuss.blow.kernels.machine_records import Bit, Chain, Face, Machine
from percuss.blow.machine.cell_damping import drag_of, quiet_drag
from percuss.blow.machine.lattice import Lattice, lattice_of
from percuss.blow.target import Rod, Target, Wall
from percuss.errors import ParameterError
from percuss.model import Load, System
from percuss.model.body import SteppedBar, UniformBar
from percuss.model.checks import Array

__all__ = ["machine_record", "rod_sections"]

_TURN = 2.0 * math.pi
_WAYS = 4.0  # of a wave through a tool without contact, and half a swing of its mass on the rock: then it may be fed


def rod_sections(system: System, target: Target) -> tuple[Array, Array, float]:
    """Impedances and transit times of the sections before the far end, and the impedance there; dimensionless.

    Raises
    ------
    ParameterError
        For masses between the sections, or a rod in SI before a striker that is not.
    """
    none = np.zeros(0)
    if isinstance(target, Wall):
        return none, none, math.inf
    if any(mass > 0.0 for _, mass in target.joint_masses):
        raise ParameterError("joint_masses", target.joint_masses, "none", "give a short section instead")
    if target.impedance is not None:
        return none, none, target.impedance / _impedance_scale(system)
    pieces = target.pieces
    if not system.is_si:
        raise ParameterError("target", "a rod in SI", "an impedance", "use Rod.of_impedance before a dimensionless bar")
    impedances = np.array([piece.impedance for piece in pieces]) / _impedance_scale(system)
    own = pieces[:-1] if target.end == "infinite" else pieces
    times = np.array([piece.transit_time for piece in own]) * system.angular_frequency
    return impedances[: len(own)], times, float(impedances[-1]) if target.end == "infinite" else math.inf


def _is_fed(target: Target) -> bool:
    """Whether the rod is fed between blows: it has an end that nothing holds, or only rock does."""
    return isinstance(target, Rod) and target.end in ("free", "rock")


_NO_BIT = Bit(False, 1.0, 0.0, 0.0, 1.0, 0.0, False, 0.0)


def _bit(system: System, target: Target, scale: float, *, impedance: float, transit: float, pushed_back: bool) -> Bit:
    """The far end of a tool that is fed; `scale` is that of the masses on the lattice, `transit` that of the tool."""
    if not (isinstance(target, Rod) and _is_fed(target)):
        return _NO_BIT
    bar, rate, rock = system.bar, system.angular_frequency, target.rock
    assert bar is not None  # a rod that is not endless is one in SI
    if rock is None and not pushed_back:
        raise ParameterError("pushed_back", False, "True for a rod with a free end, which nothing else brings back")
    stiffness = 0.0 if rock is None else rock.stiffness / (bar.mass * rate**2)
    ratio, gap = (1.0, 0.0) if rock is None else (rock.unloading_ratio, rock.gap / bar.length)
    mass = target.bit_mass / bar.mass * scale
    wait = _WAYS * transit
    if stiffness:
        whole = sum(piece.mass for piece in target.pieces) + target.bit_mass
        wait += math.pi * math.sqrt(whole / bar.mass / stiffness)
    return Bit(True, impedance, mass, stiffness * scale, ratio, gap, not pushed_back, wait)


def _impedance_scale(system: System) -> float:
    """M Ω in N·s/m, or 1 for a dimensionless system."""
    return system.bar.mass * system.angular_frequency if system.bar is not None else 1.0


def machine_record(
    system: System, target: Target, cells: int, *, pushed_back: bool, quiet: bool
) -> tuple[Lattice, Machine]:
    """The lattice of at least so many cells in the striker, and a machine at rest on it."""
    own_z, own_times = _striker_sections(system)
    z, times, behind = rod_sections(system, target)
    lattice = lattice_of(np.concatenate([own_z, z]), np.concatenate([own_times, times]), own_z.size, cells)
    scaled, k = np.asarray(lattice.impedances), own_z.size
    bar = _chain(scaled[:k], lattice.cells[:k])
    rod = _chain(scaled[k:], lattice.cells[k:])
    scale = scaled[0] / own_z[0]
    behind *= scale
    struck = float(scaled[k]) if z.size else behind
    striker = float(scaled[k - 1])
    moves = not _is_fed(target)
    face = Face(2.0 / (1.0 / striker + 1.0 / struck), 1.0 / striker, 1.0 / struck, behind, moves and pushed_back)
    ends = {"impedance": float(scaled[-1]), "transit": sum(lattice.cells[k:]) * lattice.step}
    bit = _bit(system, target, scale, pushed_back=pushed_back, **ends)
    drag = quiet_drag(lattice) if quiet else drag_of(lattice, system.body.damping)
    load = load_means(system.load, lattice.steps)
    return lattice, Machine(bar, rod, face, bit, load, system.load.at, lattice.step, drag)


def _striker_sections(system: System) -> tuple[Array, Array]:
    body = system.body
    if isinstance(body, UniformBar):
        return np.array([body.s]), np.array([1.0 / body.s])
    if isinstance(body, SteppedBar):
        return body.sections.impedance, body.sections.transit
    raise ParameterError("body", body.kind, "a bar of sections: waves need impedances and transit times")


def _chain(impedances: Array, cells: tuple[int, ...]) -> Chain:
    numbers = np.asarray(cells, dtype=np.int64)
    first: npt.NDArray[np.int64] = np.cumsum(numbers) - numbers
    total = int(numbers.sum())
    slot = np.zeros(numbers.size, dtype=np.int64)
    return Chain(np.array(impedances), first, numbers, slot, np.zeros(total), np.zeros(total))


def load_means(load: Load, steps: int) -> Array:
    """Mean of the load over each of the equal steps of a period; shape (steps,)."""
    step = _TURN / steps
    if load.is_piecewise:
        return np.asarray(load.mean + np.diff(load.antiderivative(np.arange(steps + 1) * step)) / step)
    k = np.arange(load.coefficients.size)
    waves = load.coefficients.copy()
    waves[1:] *= np.expm1(1j * k[1:] * step) / (1j * k[1:] * step)
    folded = np.zeros(steps, dtype=complex)
    np.add.at(folded, k % steps, waves)
    return np.asarray((np.fft.ifft(folded) * steps).real)
