"""Deflection of a stepped shaft, clamped at one end and loaded at the other, by finite elements.

``python shaft.py DECK`` reads lines of the deck - ``modulus MPa``, ``load N`` and, from the clamp
on, ``segment diameter length`` in mm - and writes ``deflection.csv``. It stands for any solver: it
knows nothing of who calls it.
"""

import math
import sys


def stiffness(bending, length):
    """Return a beam element's 4 x 4 matrix: deflection and slope at its two ends."""
    s, h = bending / length**3, length
    return [
        [12 * s, 6 * h * s, -12 * s, 6 * h * s],
        [6 * h * s, 4 * h * h * s, -6 * h * s, 2 * h * h * s],
        [-12 * s, -6 * h * s, 12 * s, -6 * h * s],
        [6 * h * s, 2 * h * h * s, -6 * h * s, 4 * h * h * s],
    ]


def solve(matrix, right):
    """Return the solution by elimination; the matrix is positive definite."""
    n = len(right)
    for k in range(n):
        for i in range(k + 1, n):
            factor = matrix[i][k] / matrix[k][k]
            right[i] -= factor * right[k]
            for j in range(k, n):
                matrix[i][j] -= factor * matrix[k][j]
    for k in reversed(range(n)):
        right[k] -= sum(matrix[k][j] * right[j] for j in range(k + 1, n))
        right[k] /= matrix[k][k]
    return right


def deflections(modulus, load, segments):
    """Return (place, deflection) at each segment's end, mm."""
    n = 2 * len(segments)
    matrix = [[0.0] * n for _ in range(n)]
    for k, (diameter, length) in enumerate(segments):
        element = stiffness(modulus * math.pi * diameter**4 / 64, length)
        for i in range(4):
            for j in range(4):
                row, column = 2 * k - 2 + i, 2 * k - 2 + j
                if row >= 0 and column >= 0:  # the clamp neither moves nor turns
                    matrix[row][column] += element[i][j]
    moved = solve(matrix, [0.0] * (n - 2) + [load, 0.0])
    places = [sum(length for _, length in segments[: k + 1]) for k in range(len(segments))]
    return list(zip(places, moved[::2], strict=True))


def main(deck):
    """Read the deck, solve, write the deflections."""
    with open(deck) as file:
        words = [line.split() for line in file if line.strip() and not line.startswith("#")]
    given = {key: [float(v) for v in values] for key, *values in words if key != "segment"}
    segments = [tuple(map(float, values)) for key, *values in words if key == "segment"]
    if any(diameter <= 0 for diameter, _ in segments):
        sys.exit("shaft.py: a diameter is not above 0")
    with open("deflection.csv", "w") as file:
        file.write("place,deflection\n")
        for place, moved in deflections(*given["modulus"], *given["load"], segments):
            file.write(f"{place!r},{moved!r}\n")


if __name__ == "__main__":
    main(sys.argv[1])
