"""Recordings that come as bytes from somebody unknown: read in a process of their own, with little memory and time."""
