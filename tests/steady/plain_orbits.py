"""What the compiled functions for orbits are held to: the motion by a linear system for each mode, and the search."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.mechanics.flow import phi1, phi2, propagator
from percuss.model.checks import Array
from percuss.steady.forced import forced_response
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.periodic_orbit import differences
from percuss.steady.periodic.search import COALESCED, Outcome


class Plain(NamedTuple):
    """As of a `Passage`, with the states just before the impacts, (p, N), and f_n, f_n' there."""

    force: Array
    rigid: Array
    rebound: Array
    speed: Array
    gap: Array
    closure: float
    elastic: tuple[Array, Array, Array, Array]


def passage(chain: ImpactChain, times: Array, rebound: float | None = None) -> Plain:
    """The motion through impacts at times: every state comes back after the cycle; of a bar that is no `is_neutral`."""
    system, known, p = chain.system, chain.known, chain.impacts
    alpha, beta = system.contact.strain_factor, system.contact.velocity_factor
    response, flights = forced_response(system), np.diff(times, append=times[0] + chain.period)
    f, rate = (part.T for part in response.modal(chain.modes, times)) if chain.modes else np.empty((2, p, 0))
    u, v = np.empty((2, p, chain.modes))
    for n in range(chain.modes):
        flow = np.array(propagator(known.omega[n], known.damping[n], flights)[:4]).T.reshape(p, 2, 2)
        forced = np.stack([f[:, n], rate[:, n]], axis=1)
        states = _closed(
            [np.diag([alpha, beta]) @ step for step in flow], [(alpha - 1.0, beta - 1.0) * w for w in forced]
        )
        for i in range(p):  # `states`: after each impact, less what is forced
            u[(i + 1) % p, n], v[(i + 1) % p, n] = flow[i] @ states[i] + forced[(i + 1) % p]
    end, force = u @ known.gamma, system.load.value(times)
    if not system.body.is_free:
        still = np.zeros(p)
        given = 0.0 if rebound is None else rebound
        return Plain(force, still, still + given, v @ known.gamma, end - system.body.gap, -given, (u, v, f, rate))
    fade, stay, swing = flights * phi1(system.d * flights), np.exp(-system.d * flights), response.rigid_velocity(times)
    pushed = np.roll(swing, -1) + system.load.mean * fade - swing * stay
    if rebound is None:
        rebound = float(_closed([beta * one * np.eye(1) for one in stay], np.roll(beta * pushed, 1)[:, None])[0, 0])
    after, before = np.empty(p + 1), np.empty(p)
    after[0] = rebound
    for i in range(p):
        before[(i + 1) % p] = after[i] * stay[i] + pushed[i]
        after[i + 1] = beta * before[(i + 1) % p]
    place = response.rigid_displacement(times)
    gap = np.roll(end + place, -1) - alpha * end - place + system.load.mean * flights**2 * phi2(system.d * flights)
    gap += (after[:-1] - swing) * fade
    return Plain(force, before, after[:-1], before + v @ known.gamma, gap, float(after[-1] - rebound), (u, v, f, rate))


def _closed(flow: list[Array], push: Array | list[Array]) -> Array:
    """States s_0 … s_{p−1} with s_{i+1} = flow_i s_i + push_{i+1}, the last of which leads back to the first."""
    p, size = len(flow), flow[0].shape[0]
    matrix = np.eye(p * size)
    for i, step in enumerate(flow):
        to = (i + 1) % p
        matrix[to * size : (to + 1) * size, i * size : (i + 1) * size] -= step
    return np.linalg.lstsq(matrix, np.concatenate(push), rcond=None)[0].reshape(p, size)


# ---- Newton's method on the times, away from known roots: what `percuss.steady.periodic.search.newton` does

_STEPS, _LONGEST, _KEPT, _CLOSE, _STEADY = 60, 0.5, 0.1, 1e-9, 1e-3


def newton(chain: ImpactChain, start: Array, known: Array | None, turn: float) -> tuple[Array, float, Outcome]:
    """Follow one start; the times where it ends, the rigid velocity after the first impact, and how."""
    times, settling = np.array(start), 0
    rebound = float(chain.passage(times).rebound[0]) if chain.is_neutral else None
    for _ in range(_STEPS):
        here = chain.passage(times, rebound)
        step = np.linalg.solve(here.bordered(1.0), -np.append(here.gap, here.closure))
        share = 1.0 if settling else _share(chain, times, here.flights, step[:-1], known, turn)
        step, size, turned = share * step, np.abs(step[:-1]).max(), here.force[0] - chain.system.d * here.rebound[0]
        times = times + step[:-1]
        last = float(here.rebound[0] + step[-1] + turned * step[0])
        rebound = last if chain.is_neutral else None
        flights = np.diff(times, append=times[0] + chain.period)
        calm = np.abs(flights / here.flights - 1.0).max() <= _STEADY
        settling = settling + 1 if calm and (settling or size <= _CLOSE) else 0
        if flights.min() < COALESCED * chain.period:
            return times, last, Outcome.COALESCED
        if settling > 2:
            return times, last, Outcome.ROOT
    return times, last, Outcome.LOST


def _share(chain: ImpactChain, times: Array, flights: Array, step: Array, known: Array | None, turn: float) -> float:
    """What part of a step is taken: 1/(1 − ∇ ln Π(1 + 1/d_k²) · δt) of it, not too far, leaving some of each flight."""
    share = np.float64(1.0)
    with np.errstate(divide="ignore", invalid="ignore"):  # on a known root itself
        for shifts in [] if known is None else differences(times, known, chain.period, turn):
            off = min(shifts, key=lambda one: float(one @ one))
            share += 2.0 * (off @ step) / ((off @ off) * (off @ off + 1.0))
        share = 1.0 / share
    share = share if np.isfinite(share) else np.float64(1.0)
    share *= min(1.0, _LONGEST / max(float(np.abs(share * step).max()), 1e-300))
    shrinking = -share * np.diff(step, append=step[0])
    return float(share) * min([1.0, *((1.0 - _KEPT) * flights[shrinking > 0.0] / shrinking[shrinking > 0.0])])
