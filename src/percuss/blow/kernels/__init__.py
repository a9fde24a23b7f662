"""The waves of a blow, compiled: plain functions of numbers, arrays and records, which import nothing of ours.

A wave in a section is a function of the time at which it left the section's end: a row of pieces, each a Chebyshev
polynomial, mostly a constant. Nodes join the sections: the driven end, steps, the struck face, the far end. Each node
reads what arrives and writes what leaves, as far as its arrivals are known; nothing waits for a common clock.
Times are whole numbers of a tick, so that sums of transit times are exact.
"""
