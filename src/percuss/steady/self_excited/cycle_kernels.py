"""The cycles of many rigid pistons under their valves, compiled: `piston_kernels` over arrays."""

from __future__ import annotations

from percuss.compiled import entry, twin
from percuss.steady.self_excited import piston_kernels as one

MOST = 8  # the most pending orders; with more of them there is no answer

ROW, SLOPES, NUMBERS = one.DUE + 2 * MOST, one.BY_ORDER + MOST, 1 + MOST
TOLD, DURATION, SPEED, FARTHEST, WORK, RISE = one.TOLD, one.DURATION, one.SPEED, one.FARTHEST, one.WORK, one.RISE
RUNS, DOUBLE, OVERTAKEN, UNKNOWN = one.RUNS, one.DOUBLE, one.OVERTAKEN, one.UNKNOWN
NEXT, ALL, WHOLE, COUNT = one.NEXT, one.ALL, one.WHOLE, one.COUNT
ROWS, MATRICES = one.FIRST + one.MOST_BLOWS, one.MATRICES

PistonTables = one.PistonTables
copied, settled, contracts, starts = (twin(f) for f in (one.copied, one.settled, one.contracts, one.starts))


@entry
def cycles_of(
    forces, ports, laws, first, starting, rows, slopes, matrices, tells, step, does, told, derivatives, begun
):
    """What each piston does, `does`; of one that runs what its cycle tells, and the derivatives of its return map."""
    # With `starting` it is looked if it starts from rest in its state `first`: `begun`. The tables are to work in.
    for i in range(does.size):
        work = PistonTables(forces[i], ports[i], laws[i], rows, slopes, matrices, tells, step)
        does[i] = settled(work)[0]
        size = 1 + int(rows[NEXT][COUNT])
        if does[i] == RUNS:
            copied(tells[WHOLE], told[i])
            for k in range(size):
                for m in range(size):
                    derivatives[i, k, m] = matrices[ALL, k, m]
        if starting and does[i] in (RUNS, DOUBLE, OVERTAKEN):
            attracts = does[i] == RUNS and contracts(size, work)
            begun[i] = starts(first[i], attracts, work)
