"""Orders of the valve that wait: none is lost, however many they are."""

import numpy as np

from percuss.model import Kept, Machine, Port, UniformBar, Valve
from percuss.model.load.valve import Orders
from percuss.simulate import Start, Stop, run, simulate_many

LATE = 600.0
BOUNCING = Machine(
    UniformBar(20.0),
    Valve(
        {"power": 1.0, "return": 0.5},
        [Port("return", on="impact", delay=LATE), Port("power", behind=0.3, side="back", delay=LATE)],
    ),
    Kept(1.0),
)
"""Bounces for ever, and demands twice in each flight what is done much later."""


def test_every_order_of_hundreds_is_carried_out():
    stop = Stop(impacts=100_000, time=1.4 * LATE, periodic=False)
    motion = run(BOUNCING, Start.rigid(-1.0), modes=0, stop=stop)
    events, names = motion.events, BOUNCING.valve.pairs
    demands, changes = events.port >= 0, events.kind == "valve"
    due = events.time[demands] + LATE
    done = due < stop.time
    assert np.count_nonzero(due < 2.0 * LATE) > 400 and np.count_nonzero(done) > 150  # so many wait at once
    assert np.allclose(events.time[changes], due[done], rtol=0.0, atol=1e-9)
    demanded = [("return", "power")[port] for port in events.port[demands][done]]
    assert [names[state][0] for state in events.piece[changes]] == demanded
    many = simulate_many(BOUNCING, Start.rigid(-1.0), modes=0, stop=stop)
    assert many.outcome[0] == motion.outcome == "time" and many.impacts[0] == motion.impacts


def test_a_start_may_have_as_many_orders_as_it_likes():
    pending = tuple((0.5 + 0.01 * i, ("return", "power")[i % 2]) for i in range(700))
    start = Start.rigid(-1.0).with_valve("power", Orders("power", pending))
    motion = run(BOUNCING, start, modes=0, stop=Stop(impacts=100_000, time=8.0, periodic=False))
    times = motion.events.time[motion.events.kind == "valve"]
    assert np.allclose(times, [time for time, _ in pending], rtol=0.0, atol=1e-9)


def test_a_motion_with_hundreds_of_orders_is_broken_off_and_goes_on():
    stop = Stop(impacts=100_000, time=1.1 * LATE, periodic=False)
    whole = run(BOUNCING, Start.rigid(-1.0), modes=0, stop=stop)
    part = run(BOUNCING, Start.rigid(-1.0), modes=0, stop=Stop(impacts=100_000, time=0.9 * LATE, periodic=False))
    again = part.continued(stop)
    assert len(part.events) < len(whole.events)
    assert np.array_equal(again.events.time, whole.events.time) and np.array_equal(again.states, whole.states)
