"""The records of a machine whose oil flows: what their numbers are called, in kernels and outside."""

from __future__ import annotations

from typing import Any, NamedTuple

ORDER, ELASTIC_ORDER = 24, 40  # of the series, of a rigid piston, and with modes, which ask for short steps
NODES, ELASTIC_NODES = 8, 10  # of Gauss's rule within a step, for the derivatives: even numbers
ACCURACY = 1e-17  # what the last two terms may add, of the scales

# numbers of the law; the tables of the states hold a, t, b for v > 0, b for v < 0, then each chamber's part of the b's
FORCE, KAPPA, GAS, COLUMN, EXPONENT, FLOW, SLIP, POWER, LEAK, RELIEF, SLOPE, COMPLIANCE, VOLUME, PRECHARGE = range(14)
ATMOSPHERE, POLYTROPIC, TANK, SPOOL, FACTOR, STRAIN, FED, QUICKENING, SPEED, UNIT, CORNER, CORNER_TO = range(14, 26)
WAVE, LAW = 26, 27
AREA, TANKED, DRAG_OUT, DRAG_BACK, CHAMBERS = range(5)
OMEGA2, DAMPING, DRIVEN, END = range(4)
TO, LEVEL, SIDE, DELAY, OF_SPEED, ON_IMPACT = range(6)
# of the state of a motion
TIME, PRESSURE, SIGN, OPEN, FILLED, LIMITED, RESTING, LAST, COUNT, STROKE, STATE, BLOWS, WALL, TURNED = range(14)
AT_RELIEF, AT_CHARGE, AT_CORNER, AT_ZERO, HOLD, NOW = range(14, 20)
CLOSED, OPENED, KEPT = 0.0, 1.0, 2.0
# of the sums
(PUMPED_ENERGY, LEAK_LOSS, RELIEF_LOSS, RETURN_LOSS, DRAG_LOSS, IMPACT_LOSS, PUMPED, LEAKED, RELIEVED, DRAWN, PRESSED,
 LEAST, GREATEST, FARTHEST, ORIFICES) = range(15)  # fmt: skip
# events, and how a call ends
IMPACT, PORT_MET, VALVE, REST, LEAVES, OPENS, CLOSES, EMPTIES, FILLS, LIMITS, FULL_FLOW, DRY = range(1, 13)
BY_TIME, BY_BLOWS, AT_SECTION, NO_PRESSURE, LOG_FULL, STEPS_FULL, NO_STEP, CROWDED, EMPTY_LINE = range(1, 10)
EVENT = 5  # time, kind, detail, pressure, number of the step that begins there; then the bar
STEP = 8  # time, length, pressure, sign, open, filled, limited, resting; then the blend and the bar

# rows of the series of a step
U, V, P, F, W, A, Y, Z, C, S, N, Q, RISE, SPIN, POLY, BEND, CUBE, SQUARE, ROWS = range(19)


class OilLaw(NamedTuple):
    """What does not change: numbers, modes (4, n), what ports read (p, n), joins of the states and ports."""

    numbers: Any
    modes: Any
    reads: Any
    joins: Any
    ports: Any


class OilState(NamedTuple):
    """A motion on its way: numbers, bar (2, n), blend of the joins and its slope, orders (q, 2), port flags, sums.

    `bars`, (2 n + 1, D), `dues`, (q, D), `blends`, (2, 4, D), and `shift`, (D,) are its derivatives in D directions.
    """

    now: Any
    bar: Any
    blend: Any
    orders: Any
    touched: Any
    sums: Any
    bars: Any
    dues: Any
    blends: Any
    shift: Any


class OilWork(NamedTuple):
    """Room: series (ROWS, K + 2), of modes and rates (K + 2, n) each, polynomials, rates before and after an event.

    Of the derivatives: Gauss's nodes and weights, (2, q), parts (q, q, q) of their polynomials and integrals (q, q) up
    to a node, the step that is kept and that of the tables, (2,), and these: at the nodes by modes (2, q, 2 n) and
    forces (2, q, q), at the end by modes (4, n) and forces (2, n, q); their equations, (2 q, 2 q) and (2 q, D).
    """

    series: Any
    places: Any
    rates: Any
    stack: Any
    ends: Any
    before: Any
    after: Any
    times: Any
    nodes: Any
    parts: Any
    swept: Any
    span: Any
    seen: Any
    pulled: Any
    turned: Any
    answers: Any
    matrix: Any
    columns: Any


class OilLog(NamedTuple):
    """Events, (m, EVENT + 2 n), steps, (k, STEP + 2 w + 2 n), and how many of each there are."""

    events: Any
    steps: Any
    filled: Any
