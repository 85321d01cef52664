#!/usr/bin/env python3
# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy"]
# ///
"""Would Newton's method solve the windows of a scene faster than sweeps do?

    uv run scripts/newton.py [--json]

Counts the iterations that the weak scheme on 24 Gauss–Lobatto nodes needs to solve a window to 1e-13, from the best of
three guesses (the rates of the window before, the tangent, a constant), on four motions and several lengths of windows:
by sweeps (momenta, then positions), by a simplified Newton method (one Jacobian, of the middle of the window), and by
Newton's method (a Jacobian at every node). `tail` is the largest of the two highest modes of the exact rates, relative
to the largest mode: where it is above 1e-12, it is the resolution that limits a window to 1e-13 or longer ones, and
not the sweeps.
"""

import argparse
import json
import math
import sys

import numpy as np
from numpy.polynomial import legendre

NODES = 24
TOLERANCE = 1e-13
MOST = 60
METHODS = ("sweeps", "simplified", "newton")


def lobatto(n):
    highest = np.zeros(n)
    highest[-1] = 1.0
    inner = np.sort(legendre.legroots(legendre.legder(highest)))
    return np.concatenate([[0.0], 0.5 * (inner + 1.0), [1.0]])


S = lobatto(NODES)
TO_MODES = np.linalg.inv(legendre.legvander(2.0 * S - 1.0, NODES - 1))
INTEGRALS = [legendre.legval(2.0 * S - 1.0, legendre.legint(row, lbnd=-1)) / 2.0 for row in np.eye(NODES)]
A = np.array(INTEGRALS).T @ TO_MODES


def values(nodal, at):
    """The polynomial through nodal values."""
    return legendre.legvander(2.0 * at - 1.0, NODES - 1) @ (TO_MODES @ nodal)


def star(y):
    x, y, p_x, p_y = y.T
    return np.stack([p_x, p_y, -x - 2.0 * x * y, -y - x * x + y * y], 1)


def oscillator(y):
    x, y, p_x, p_y = y.T
    return np.stack([p_x, p_y, -x, -y], 1)


def ellipse(y):
    x, y, p_x, p_y = y.T
    cube = (x * x + y * y) ** -1.5
    return np.stack([p_x, p_y, -x * cube, -y * cube], 1)


SEMI_LATUS, ECCENTRICITY = 10.0, 0.5
ENERGY = ((SEMI_LATUS - 2.0) ** 2 - 4.0 * ECCENTRICITY**2) / (SEMI_LATUS * (SEMI_LATUS - 3.0 - ECCENTRICITY**2))
MOMENTUM = SEMI_LATUS**2 / (SEMI_LATUS - 3.0 - ECCENTRICITY**2)


def black_hole(y):
    """r and p_r of a bound orbit; E² and L² are ENERGY and MOMENTUM."""
    r, p = y.T
    f, slope = 1.0 - 2.0 / r, 2.0 / r**2
    return np.stack([f * p, -0.5 * (ENERGY * slope / f**2 + slope * p * p - 2.0 * MOMENTUM / r**3)], 1)


def jacobian(field, y):
    n, d = y.shape
    result = np.zeros((n, d, d))
    for k in range(d):
        step = np.zeros(d)
        step[k] = 1e-6 * (1.0 + np.abs(y[:, k]).max())
        result[:, :, k] = (field(y + step) - field(y - step)) / (2.0 * step[k])
    return result


def solve(field, start, h, guess, method, tolerance=TOLERANCE):
    """The nodal values and the iterations that they took, MOST if they did not converge."""
    d, m = len(start), len(start) // 2
    y = guess.copy()
    if method == "simplified":
        matrix = np.eye(NODES * d) - h * np.kron(A, jacobian(field, y[NODES // 2][None])[0])
        inverse = np.linalg.inv(matrix)
    for iteration in range(1, MOST):
        if method == "sweeps":
            half = y.copy()
            half[:, m:] = start[m:] + h * (A @ field(y)[:, m:])
            new = half.copy()
            new[:, :m] = start[:m] + h * (A @ field(half)[:, :m])
        else:
            residual = (start + h * (A @ field(y)) - y).reshape(-1)
            if method == "newton":
                blocks = h * np.einsum("ij,jab->iajb", A, jacobian(field, y)).reshape(NODES * d, NODES * d)
                new = y + np.linalg.solve(np.eye(NODES * d) - blocks, residual).reshape(y.shape)
            else:
                new = y + (inverse @ residual).reshape(y.shape)
        sizes = np.abs(y).max(0)
        change = (np.abs(new - y).max(0) / (sizes + 1e-2 * sizes.max())).max()
        y = new
        if not change < 1e6:
            break
        if change < tolerance:
            return y, iteration
    return y, MOST


def exact(field, start, h, parts=8):
    """The nodal values by short windows."""
    nodal = np.zeros((NODES, len(start)))
    for part in range(parts):
        y, _ = solve(field, start, h / parts, np.tile(start, (NODES, 1)), "newton", 1e-14)
        low, high = part / parts, (part + 1) / parts
        inside = (S >= low - 1e-15) & (S <= high + 1e-15)
        nodal[inside] = values(y, (S[inside] - low) * parts)
        start = y[-1]
    return nodal


def march(name, field, start, lengths):
    start, before = np.array(start, float), None
    tails, counts = [], {method: [] for method in METHODS}
    for h in lengths:
        truth = exact(field, start, h)
        guesses = [np.tile(start, (NODES, 1)), start + np.outer(S * h, field(start[None])[0])]
        if before is not None:
            rates, length = before
            guesses.append(start + h * (A @ values(rates, 1.0 + S * h / length)))
        for method, found in counts.items():
            found.append(min(solve(field, start, h, guess, method)[1] for guess in guesses))
        rates = field(truth)
        modes = np.abs(TO_MODES @ rates)
        tails.append(modes[-2:].max() / modes.max())
        before, start = (rates, h), truth[-1]
    # The first window has none before it.
    means = {method: float(np.mean(found[1:])) for method, found in counts.items()}
    return {"motion": name, "windows": len(lengths), "largest tail": float(max(tails)), **means}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    rows = []
    for h in (4.0, 8.0, 12.0):
        rows.append(march(f"oscillator, h = {h:g}", oscillator, [0.1, 0.0, 0.0, 0.5], [h] * 12))
    for h in (2.0, 3.0, 4.0):
        rows.append(march(f"star in a galaxy, h = {h:g}", star, [0.1, 0.0, 0.0, 0.5], [h] * 20))
    for h in (50.0, 75.0):
        start = [SEMI_LATUS / (1.0 + ECCENTRICITY), 0.0]
        rows.append(march(f"orbit around a black hole, h = {h:g}", black_hole, start, [h] * int(1950 / h)))
    for windows in (18, 12):
        # Equal steps of the eccentric anomaly.
        anomaly = np.linspace(0.0, 2.0 * math.pi, windows + 1)
        lengths = np.diff(anomaly - 0.9 * np.sin(anomaly))
        start = [0.1, 0.0, 0.0, math.sqrt(19.0)]
        rows.append(march(f"ellipse, e = 0.9, {windows} windows a turn", ellipse, start, lengths))
    if parser.parse_args().json:
        return json.dump(rows, sys.stdout)
    for row in rows:
        tail, *counts = (row[key] for key in ("largest tail", *METHODS))
        print(f"{row['motion']:36} tail {tail:.0e}", *(f"{name} {count:.1f}" for name, count in zip(METHODS, counts)))


if __name__ == "__main__":
    main()
