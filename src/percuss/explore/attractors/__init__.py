"""Where motions end: random starts, attractors and their shares, basins of attraction."""
