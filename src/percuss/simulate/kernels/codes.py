"""Numbers that the functions of this room share, and the codes in their records."""

from __future__ import annotations

import math

import numpy as np

TURN = 2.0 * math.pi
TURN_LOW = 2.4492935982947064e-16  # 2π less its double
EPS = 2.0**-52
SLICE = 1 << 17  # evaluations of a member of an ensemble between two looks at the outside
WINDOW = 256  # last impacts kept for the classifier, at least; always a power of 2
LOOSE = 1e-3  # how near impacts must come back to be of one cycle, when nothing more is asked

# -- codes ----------------------------------------------------------------------------------------------------------

# what the anchor is, `count.mode`
FLYING, ON_WALL, RESTING, GRAZED = range(4)
# kinds of events: numbers of NumPy, as a Python number is a type of its own for which `record` is compiled again
IMPACT, GRAZING, CHATTER, REST, RELEASE, PORT, VALVE = np.arange(7)
# what a call ends with, or that the motion goes on
FULL, BY_IMPACTS, BY_TIME, AT_REST, PERIODIC, DEPARTED, BY_WORK, TO_VERIFY, UNRESOLVED, GOES_ON = range(10)
# … and that of a machine: it orbits in its chamber for ever, or switches without end at a port; or more orders wait
# than there is room for
IN_CHAMBER, ON_PORT, CROWDED = 10, 11, 12
# what a search for the next contact ends with, or that it is still open
NOTHING, CONTACT, GRAZE, AWAY, TIRED, OPEN = range(6)
# … and what a port's next crossing is: it is entered, left, neither before a horizon, or neither ever
ENTERS, LEAVES, NOWHERE, NEVER = 6, 7, 8, 9
# `count.verdict` on two equal releases: none yet, none in a twin yet, to be tested, the cycle is sure, lost in rounding
UNSEEN, TWIN, ASKED, SURE, LOST_CYCLE = range(5)
# `bar.law`: the frequencies are multiples of one, and one damping holds for all; frequencies and dampings are multiples
# of one; each mode by itself
POWERS, RATIO, SINGLY = range(3)
