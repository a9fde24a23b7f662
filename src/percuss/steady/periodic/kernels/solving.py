"""Small systems of linear equations, by elimination with row pivots, and determinants."""

import math

from percuss.compiled import inner

__all__ = ["determinant", "reduced", "solved"]

TINY = 2.0**-52


@inner
def reduced(matrix, size, columns):
    """Eliminate below the diagonal, in place; the sign of the permutation.

    A pivot that vanishes becomes one less than rounding: the solution is then far away, and shows that there is none.
    """
    sign, greatest = 1.0, 0.0
    for i in range(size):
        for j in range(size):
            greatest = max(greatest, abs(matrix[i, j]))
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if best != k:
            sign = -sign
            for j in range(columns):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        if matrix[k, k] == 0.0:
            matrix[k, k] = TINY * TINY * greatest
        for i in range(k + 1, size):
            factor = matrix[i, k] / matrix[k, k]
            if factor != 0.0:
                for j in range(k + 1, columns):
                    matrix[i, j] -= factor * matrix[k, j]
    return sign


@inner
def solved(matrix, size, column):
    """The solution for one of the columns beside a matrix that is `reduced`, into that column."""
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            matrix[i, column] -= matrix[i, j] * matrix[j, column]
        matrix[i, column] /= matrix[i, i]


@inner
def determinant(matrix, size):
    """The determinant, each row taken by its length; the matrix is lost."""
    for i in range(size):
        length = 0.0
        for j in range(size):
            length += matrix[i, j] * matrix[i, j]
        length = math.sqrt(length)
        if length == 0.0:
            return 0.0
        for j in range(size):
            matrix[i, j] /= length
    found = reduced(matrix, size, size)
    for i in range(size):
        found *= matrix[i, i]
    return found
