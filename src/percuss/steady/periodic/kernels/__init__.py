"""The compiled functions for orbits: the equations for the times of the impacts, Newton's method, steps along a branch.

They compute one motion at a time, in plain numbers and in arrays that the caller owns; theory and notation are those of
`percuss.steady.periodic.impact_chain`. Nothing of ours is imported but the decorators.
"""
