"""What damping takes from the velocities of the striker's cells; their strain stays."""

from __future__ import annotations

from percuss.compiled import inlined, summed


@summed
def row_times(matrix, i, vector):
    """Row i of a matrix times a vector."""
    total = 0.0
    for j in range(vector.size):
        total += matrix[i, j] * vector[j]
    return total


@inlined
def places(cells, slot, cell):
    """Where the waves to the right and to the left are kept that are in a cell of a section now."""
    right, left = slot + cells - 1 - cell, slot + cell
    return right - cells if right >= cells else right, left - cells if left >= cells else left


@inlined
def gathered(chain, drag):
    """The velocity of every cell, in order of space, and its mean in every block."""
    at = 0
    drag.mean[:] = 0.0
    for i in range(chain.cells.size):
        first, cells, slot = chain.first[i], chain.cells[i], chain.slot[i]
        for cell in range(cells):
            right, left = places(cells, slot, cell)
            velocity = chain.right[first + right] + chain.left[first + left]
            drag.before[at] = velocity
            drag.mean[drag.block[at]] += drag.mass[at] * velocity
            at += 1
    for b in range(drag.mean.size):
        drag.mean[b] /= drag.total[b]


@inlined
def slowed(chain, drag, now):
    """Take velocity from every cell as the law of damping does in an interval."""
    gathered(chain, drag)
    carried = now.momentum if drag.carried else 0.0  # the mass is 1
    for b in range(drag.matrix.shape[0]):
        drag.change[b] = row_times(drag.matrix, b, drag.mean)
    at, taken = 0, 0.0
    for i in range(chain.cells.size):
        first, cells, slot = chain.first[i], chain.cells[i], chain.slot[i]
        for cell in range(cells):
            right, left = places(cells, slot, cell)
            before, block = drag.before[at], drag.block[at]
            if drag.matrix.size:
                change = drag.change[block] + drag.finer * (before - drag.mean[block])
            else:
                change = drag.factor * (before - carried)
            chain.right[first + right] += 0.5 * change
            chain.left[first + left] += 0.5 * change
            now.momentum += drag.mass[at] * change
            taken -= drag.mass[at] * change * (before + 0.5 * change)
            at += 1
    now.damped += taken
    now.energy -= taken
