"""Motions of a machine that switches its own valve: every blow, port and change of state from any start."""
