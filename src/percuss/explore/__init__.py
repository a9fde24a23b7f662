"""Maps, boundaries, basins and numerical experiments: any function of a system over any parameters."""
