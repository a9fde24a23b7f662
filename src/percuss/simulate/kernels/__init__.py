"""The flight of the bar, its next contact and its impact, compiled: plain functions of numbers, arrays and records.

The functions neither allocate nor raise and know no object, so that the same source can be compiled for another device.
They import nothing of ours but this room. `motion_records` says which records they share and what stands in them,
`compiled` how they are compiled and cached; Python calls those that are an `entry`: `follow`, `put_first`,
`release_phases`, `bounded`, `conclude`, and of machines `follow_valve`.

The state at an instant, the *anchor* (theory §§2, 8). The gap function is y = u_0 + Σ q_n, where q_n is what mode n
adds at the striking end: q_n'' + d_n q_n' + ω_n² q_n = γ_n p(t). Every q_n is a forced part, known for all times, and a
free one. The free part of an oscillating mode is e^{−d_nτ/2} Re z_n e^{iλ_nτ}, τ after the anchor; *creeping* modes,
which are overdamped or close to it, keep the value and the rate of their free part instead. With them go the gap y, its
rate, and the velocity of the mean of the bar. Increments since the anchor are summed, never positions, so that flights
of 1e-9 are as exact as flights of 1.
"""
