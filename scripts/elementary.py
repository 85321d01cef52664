#!/usr/bin/env python3
"""Prints the polynomials of src/number/vector/elementary/:
interpolation at Chebyshev nodes in 60 digits, as doubles.

    scripts/elementary.py

The interpolant is the best polynomial but for a factor of two or three in its error, which is printed relative to the
whole function. Needs mpmath.
"""

from mpmath import asin, atan, atanh, cos, factorial, log, lu_solve, matrix, mp, mpf, pi, sin, sqrt

mp.dps = 60

QUARTER = (pi / 4) ** 2 * mpf("1.001")
HALF_LN2 = log(2) / 2 * mpf("1.001")
LOG_EDGE = ((sqrt(mpf(2)) - 1) / (sqrt(mpf(2)) + 1)) ** 2 * mpf("1.001")


def odd(function, head):
    """(f(x)/x - head(x²))/x^(2k) as a function of z = x², for a head of k terms."""
    def rest(z):
        x = sqrt(z)
        return (function(x) / x - sum(c * z**i for i, c in enumerate(head))) / z ** len(head)
    return rest


# name, the polynomial's function, its interval, its degree, its weight against the whole
ROWS = [
    ("SIN", odd(sin, [1]), (0, QUARTER), 5, lambda z: z),
    ("COS", lambda z: (cos(sqrt(z)) - 1 + z / 2) / z**2, (0, QUARTER), 5, lambda z: z**2),
    ("EXP", lambda r: sum(r**k / factorial(k + 3) for k in range(40)), (-HALF_LN2, HALF_LN2), 9, lambda r: r * r),
    ("LN", odd(atanh, [1, mpf(1) / 3]), (0, LOG_EDGE), 7, lambda z: z**2),
    ("ATAN", odd(atan, [1]), (0, (mpf(7) / 16) ** 2 * mpf("1.001")), 10, lambda z: z),
    ("ASIN", odd(asin, [1]), (0, mpf("0.25")), 12, lambda z: z),
]


def interpolant(function, interval, degree):
    a, b = map(mpf, interval)
    nodes = [(a + b) / 2 + (b - a) / 2 * cos(pi * (2 * k + 1) / (2 * degree + 2)) for k in range(degree + 1)]
    rows = matrix([[x**j for j in range(degree + 1)] for x in nodes])
    return [float(c) for c in lu_solve(rows, matrix([function(x) for x in nodes]))]


def main():
    for name, function, (a, b), degree, weight in ROWS:
        c = interpolant(function, (a, b), degree)
        points = [a + (b - a) * (mpf(k) + mpf("0.5")) / 2000 for k in range(2000)]
        error = max(abs(weight(x) * (sum(mpf(c) * x**j for j, c in enumerate(c)) - function(x))) for x in points)
        print(f"/// Error {float(error):.1e} of the whole.\nconst {name}: [f64; {degree + 1}] = [")
        print("".join(f"    {v!r},\n" for v in c) + "];")


main()
