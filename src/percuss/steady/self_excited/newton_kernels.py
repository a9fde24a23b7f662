"""Newton's method for the cycle of a rigid piston under its valve, compiled: what `rigid_cycle` does."""

import math

from percuss.compiled import inner
from percuss.steady.self_excited.leg_kernels import (
    BLOW,
    COUNT,
    DROPPED,
    DUE,
    DURATION,
    FARTHEST,
    LAST,
    NUMBERS,
    RISE,
    SPEED,
    STATE,
    SWITCHES,
    TO,
    WORK,
    V,
    copied,
    leg,
)

MOST_BLOWS = 80  # that are followed, as in settled_cycle

# rows of rebounds: those of the legs that were followed, then what Newton's method works with, and the cycle's
NOW, NEXT, TRIAL, END = range(MOST_BLOWS, MOST_BLOWS + 4)
ROWS = MOST_BLOWS + 4
# matrices: derivatives of a leg, of all, a product, and the equations
ONE, ALL, PRODUCT, EQUATIONS = range(4)
MATRICES = 4
# rows of what legs tell: those that were followed, one leg, and all of a cycle
SINGLE, WHOLE = range(MOST_BLOWS, MOST_BLOWS + 2)
TELLING = MOST_BLOWS + 2

STEPS, SHRINKING, SHRUNK, HALVINGS, CLOSED, MEETS = 40, 16, 0.9, 6, 1e-13, 1e-9  # as in rigid_cycle
TOUCHES = 1e-12


@inner
def legs_of_cycle(forces, ports, law, begin, blows, rows, slopes, matrices, tells):
    """The flights of so many blows, when they lead to a rebound of the same kind: at `END`, and what they tell."""
    whole, single, now, following = tells[WHOLE], tells[SINGLE], rows[NOW], rows[END]
    size, one, done, product = 1 + int(begin[COUNT]), matrices[ONE], matrices[ALL], matrices[PRODUCT]
    copied(begin, now)
    whole[:], whole[RISE] = 0.0, -1.0
    for i in range(NUMBERS):
        for k in range(NUMBERS):
            done[i, k] = 1.0 if i == k else 0.0
    for _ in range(blows):
        if leg(forces, ports, law, now, False, following, slopes, one, single) != BLOW:
            return False
        for i in range(1 + int(following[COUNT])):
            for k in range(size):
                product[i, k] = 0.0
                for m in range(1 + int(now[COUNT])):
                    product[i, k] += one[i, m] * done[m, k]
        for i in range(NUMBERS):
            copied(product[i], done[i])
        for name in (DURATION, WORK, SWITCHES, DROPPED):
            whole[name] += single[name]
        for name in (SPEED, FARTHEST, RISE):
            whole[name] = max(whole[name], single[name])
        copied(following, now)
    return alike(begin, following)


@inner
def alike(one, other):
    """Whether two rebounds differ by their numbers only."""
    same = one[STATE] == other[STATE] and one[LAST] == other[LAST] and one[COUNT] == other[COUNT]
    for i in range(int(one[COUNT])):
        same = same and one[TO + i] == other[TO + i]
    return same


@inner
def solved(equations, size, step):
    """Solve for the step, which is the last column, by elimination; False where that is not possible."""
    for i in range(size):
        pivot = i
        for k in range(i + 1, size):
            if abs(equations[k, i]) > abs(equations[pivot, i]):
                pivot = k
        if equations[pivot, i] == 0.0 or not math.isfinite(equations[pivot, i]):
            return False
        for k in range(size + 1):
            equations[i, k], equations[pivot, k] = equations[pivot, k], equations[i, k]
        for k in range(i + 1, size):
            ratio = equations[k, i] / equations[i, i]
            for m in range(i, size + 1):
                equations[k, m] -= ratio * equations[i, m]
    for i in range(size - 1, -1, -1):
        value = equations[i, size]
        for k in range(i + 1, size):
            value -= equations[i, k] * step[k]
        step[i] = value / equations[i, i]
        if not math.isfinite(step[i]):
            return False
    return True


@inner
def newton_step(begin, rows, matrices, tells, step):
    """The size of the next step of Newton's method, as a part of speed or period; infinite when there is none."""
    size, equations, end = 1 + int(begin[COUNT]), matrices[EQUATIONS], rows[END]
    apart = 0.0
    for i in range(size):
        place = V if i == 0 else DUE + i - 1
        apart = max(apart, abs(end[place] - begin[place]) / tells[WHOLE, SPEED if i == 0 else DURATION])
        for k in range(size):
            equations[i, k] = (1.0 if i == k else 0.0) - matrices[ALL, i, k]
        equations[i, size] = end[place] - begin[place]
    if not solved(equations, size, step):
        return math.inf
    greatest = 0.0
    for i in range(size):
        greatest = max(greatest, abs(step[i]) / tells[WHOLE, SPEED if i == 0 else DURATION])
    return greatest if greatest > CLOSED or apart <= MEETS else math.inf


@inner
def is_idle(begin, tells):
    """Whether no demand was accepted, or the wall is only touched.

    A slower rebound passes some of the same ports, so that it changes nothing either: Newton's method leads to rest.
    """
    if not tells[WHOLE, SPEED] > 0.0:
        return True
    return begin[COUNT] == 0.0 and tells[WHOLE, SWITCHES] == 0.0 and tells[WHOLE, DROPPED] == 0.0


@inner
def strikes(forces, whole):
    """Whether it does more than touch the wall, so that rounding makes a blow of a swing that ends there."""
    force = 0.0
    for k in range(forces.size):
        force = max(force, abs(forces[k]))
    return whole[SPEED] * whole[SPEED] > TOUCHES * force * whole[FARTHEST]


@inner
def cycle_near(forces, ports, law, begin, blows, rows, slopes, matrices, tells, step):
    """Whether Newton's method leads from a rebound to a cycle with a switch: at `NEXT`, and told as a whole."""
    now, trial = rows[NEXT], rows[TRIAL]
    copied(begin, now)
    size = 1 + int(begin[COUNT])
    if not legs_of_cycle(forces, ports, law, now, blows, rows, slopes, matrices, tells):
        return False
    before = math.inf
    for number in range(STEPS):
        if is_idle(now, tells):
            return False
        far = newton_step(now, rows, matrices, tells, step)
        if far <= CLOSED:
            return strikes(forces, tells[WHOLE])
        if far == math.inf or (number >= SHRINKING and far > SHRUNK * before):
            return False
        before = far
        part, there = 1.0, False
        for _ in range(HALVINGS):
            copied(now, trial)
            allowed = True
            for i in range(size):
                place = V if i == 0 else DUE + i - 1
                trial[place] += part * step[i]
                allowed = allowed and trial[place] >= 0.0
            there = allowed and legs_of_cycle(forces, ports, law, trial, blows, rows, slopes, matrices, tells)
            if there:
                break
            part *= 0.5
        if not there:
            return False
        copied(trial, now)
    return False
