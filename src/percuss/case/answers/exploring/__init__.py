"""Answers over parameters and many starts: orbits and branches, diagrams, maps, basins, best sizes, previews."""
