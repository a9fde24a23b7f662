"""Cycles with rest on the wall: from each phase at which the load lets go, over chatter, to the next rest."""
