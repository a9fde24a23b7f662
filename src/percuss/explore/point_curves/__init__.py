"""Curves in a plane of two parameters, of each kind of point that a branch of orbits may have."""
