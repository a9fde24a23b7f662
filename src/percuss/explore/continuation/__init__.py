"""Orbits followed through a parameter: where they fold, double, touch the wall or end, and what lies beyond."""
