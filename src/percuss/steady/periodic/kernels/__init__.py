"""The compiled functions for orbits: the equations for the times of the impacts, Newton's method, steps along a branch.

They say what `impact_chain` and `linearised` say, which are the plain form and the oracle of the tests, but of one
motion at a time, in plain numbers and in arrays that the caller owns. Nothing of ours is imported but the decorators.
"""
