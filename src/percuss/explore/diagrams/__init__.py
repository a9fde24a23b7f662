"""Diagrams: what motions there are over one parameter, those that simulations settle on and those that are followed."""
