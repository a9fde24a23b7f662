"""A tool that is held, struck again and again, on a lattice of whole waves: a second program, made only to judge.

It keeps the whole waves f and g of every cell and not their departure from the static state, lets every cell relax
toward that state by itself, and takes the simplest rule at every node: springs and rock by the state at the beginning
of a step, and what switches within a step does so at its end. So its errors fall like the step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Held:
    """A striker of one section and a tool of sections (impedance, transit time), at most one joint at each step."""

    striker: tuple[float, float]
    velocity: float
    tool: list[tuple[float, float]]
    end: str = "rock"  # or "fixed", "infinite"
    bit_mass: float = 0.0
    k1: float = 0.0
    gamma: float = 1.0
    decay: list[float] = field(default_factory=list)  # alpha times length, of each section
    joints: dict[int, tuple[str, float, float]] = field(default_factory=dict)
    force: float = 0.0
    at: int = 0
    kd: float = 0.0
    cd: float = 0.0


@dataclass
class Told:
    """What a blow has done."""

    impulse: float = 0.0
    rock_impulse: float = 0.0
    feed_impulse: float = 0.0
    feed_work: float = 0.0
    deepest: float = 0.0
    penetration: float = 0.0
    returned: float = 0.0
    steel: float = 0.0
    joint: float = 0.0
    tool_energy: float = 0.0
    out: float = 0.0
    stands: bool = True


def repeated(held: Held, period: float, number: int, dt: float, new_rock: bool = True) -> list[Told]:
    """So many blows with steps of dt; every transit time is a whole number of them."""
    n = [round(tau / dt) for _, tau in held.tool]
    z = [one for one, _ in held.tool]
    static = [held.force if i >= held.at else 0.0 for i in range(len(z))]
    rest = [p / (2.0 * one) for p, one in zip(static, z, strict=True)]
    right = [np.full(cells, r) for cells, r in zip(n, rest, strict=True)]  # by place, from the struck face on
    left = [np.full(cells, -r) for cells, r in zip(n, rest, strict=True)]
    alpha = held.decay or [0.0] * len(z)
    fade = [math.exp(-a / cells) for a, cells in zip(alpha, n, strict=True)]
    speed = [0.0] * (len(z) + 1)  # of masses at steps
    spring = [held.force / k if kind == "elastic" else 0.0 for kind, k, _ in _joints(held)]
    gap = [0.0] * (len(z) - 1)
    y, u, u_m, v_bit = 0.0, 0.0, 0.0, 0.0
    if held.k1:
        u = u_m = held.force / held.k1
    zs, cells = held.striker[0], round(held.striker[1] / dt)
    told = []
    for blow in range(number):
        if blow and new_rock and held.k1:
            pressing = _rock(held, u, u_m)
            y -= u - (pressing / held.k1 if pressing > 0.0 else u - (1.0 - held.gamma) * u_m)
            u = pressing / held.k1 if pressing > 0.0 else u - (1.0 - held.gamma) * u_m
            u_m = max(u, 0.0)
        one = Told(deepest=u_m)
        f_s, g_s = np.full(cells, held.velocity / 2.0), np.full(cells, held.velocity / 2.0)
        h = 0.0
        for _ in range(round(period / dt)):
            # what arrives
            fa, gb = f_s[-1], left[0][0]
            q, zb = held.force - held.kd * y, z[0]
            fed = held.at == 0
            push = q if fed else 0.0
            damp = held.cd if fed else 0.0
            # the struck face: shut, else open, with the feed acting, else lifted
            shut = h <= 0.0
            for acting in (True, False):
                p, c = (push, damp) if acting else (0.0, 0.0)
                v = (2.0 * zs * fa + 2.0 * zb * gb + p) / (zs + zb + c)
                n_face = zs * (2.0 * fa - v)
                if not shut or n_face <= 0.0:
                    n_face, v = 0.0, (2.0 * zb * gb + p) / (zb + c)
                if not fed or p - c * v > 0.0:
                    break
            pressed = p - c * v if fed else 0.0
            v_s = 2.0 * fa - n_face / zs
            h = 0.0 if n_face > 0.0 else max(h + (v - v_s) * dt, 0.0)
            one.impulse += n_face * dt
            if fed:
                one.feed_impulse += pressed * dt
                one.feed_work += pressed * v * dt
                y += v * dt
            enter_right, enter_left = [v - gb], []
            for i in range(len(z) - 1):
                a, b = right[i][-1], left[i + 1][0]
                kind, k, c = held.joints.get(i + 1, ("", 0.0, 0.0))
                va, vb = _step(held, i, z, a, b, kind, k, c, spring, gap, speed, y, dt, one)
                if held.at == i + 1:
                    y += va * dt
                enter_left.append(va - a)
                enter_right.append(vb - b)
            f = right[-1][-1]
            if held.end == "rock":
                force = _rock(held, u, u_m)
                if held.bit_mass:
                    v_bit += (2.0 * z[-1] * f - z[-1] * v_bit - force) / held.bit_mass * dt
                else:
                    v_bit = 2.0 * f - force / z[-1]
                u += v_bit * dt
                u_m = max(u_m, u)
                one.rock_impulse += force * dt
                enter_left.append(v_bit - f)
            elif held.end == "fixed":
                enter_left.append(-f)
            else:
                enter_left.append(0.0)
                one.out += z[-1] * f * f * dt
            # everything moves on by a cell, and relaxes on the way
            f_s, g_s = np.append(g_s[0], f_s[:-1]), np.append(g_s[1:], v_s - fa)
            for i in range(len(z)):
                right[i] = np.append(enter_right[i], right[i][:-1])
                left[i] = np.append(left[i][1:], enter_left[i])
                before = z[i] * dt * (right[i] @ right[i] + left[i] @ left[i])
                right[i] = rest[i] + fade[i] * (right[i] - rest[i])
                left[i] = -rest[i] + fade[i] * (left[i] + rest[i])
                one.steel += before - z[i] * dt * (right[i] @ right[i] + left[i] @ left[i])
        one.deepest, one.penetration, one.stands = u_m, u, _rock(held, u, u_m) > 0.0
        mass = zs * cells * dt
        one.returned = 0.5 * mass * (zs * dt * (f_s.sum() + g_s.sum()) / mass) ** 2
        told.append(one)
    return told


def _joints(held: Held) -> list[tuple[str, float, float]]:
    return [held.joints.get(i, ("", 0.0, 0.0)) for i in range(1, len(held.tool))]


def _rock(held: Held, u: float, u_m: float) -> float:
    """The force at a penetration."""
    if u >= u_m:
        return max(held.k1 * u, 0.0)
    return max(held.k1 / held.gamma * (u - (1.0 - held.gamma) * u_m), 0.0)


def _step(held, i, z, a, b, kind, k, c, spring, gap, speed, y, dt, one):
    """The velocities of both faces of a step, from the whole waves that arrive."""
    za, zb = z[i], z[i + 1]
    both = 1.0 / za + 1.0 / zb
    if held.at == i + 1:
        for acting in (True, False):
            p, d = (held.force - held.kd * y, held.cd) if acting else (0.0, 0.0)
            v = (2.0 * za * a + 2.0 * zb * b + p) / (za + zb + d)
            if kind == "mass":
                v = speed[i] + (2.0 * za * a + 2.0 * zb * b + p - (za + zb + d) * speed[i]) / k * dt
            if p - d * v > 0.0:
                break
        speed[i] = v
        one.feed_impulse += (p - d * v) * dt
        one.feed_work += (p - d * v) * v * dt
        return v, v
    if kind == "mass":
        speed[i] += (2.0 * za * a + 2.0 * zb * b - (za + zb) * speed[i]) / k * dt
        return speed[i], speed[i]
    if kind == "elastic":
        force = (k * spring[i] + 2.0 * c * (a - b)) / (1.0 + c * both)
        rate = 2.0 * (a - b) - both * force
        spring[i] += rate * dt
        one.joint += c * rate * rate * dt
    elif kind == "contact":
        force = 2.0 * (a - b) / both
        if (gap[i] <= 0.0 and force >= 0.0) or (gap[i] >= k and force < 0.0):
            pass
        else:
            gap[i] = min(max(gap[i] - 2.0 * (a - b) * dt, 0.0), k)
            force = 0.0
    else:
        force = 2.0 * (a - b) / both
    return 2.0 * a - force / za, 2.0 * b + force / zb
