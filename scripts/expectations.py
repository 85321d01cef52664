#!/usr/bin/env python3
"""Reference values for the [expect] tables of the case files, in 100-digit arithmetic.

Solves the physical-limit collocation system of the discretised geodesic action,

    (Dx)_k = w_k,   (Dw)_k = -1/2 g00'(x_k) (Q/g00(x_k))^2,   (Dt)_k = Q/g00(x_k),   k = 1 .. N-1,
    t_1 = t_i,  x_1 = x_i,  w_1 = x_dot_i,  g00(x) = c^2 + 2 V(x)/m,  Q = g00(x_i) t_dot_i,

with an SBP operator D given in exact rationals, for t_N and x_N. In the weak form D + H^-1 e_1 e_1^T takes the place of
D, H^-1 e_1 times the initial value is added on the right-hand sides, and the equations hold at all nodes. The numbers
of a case file are taken as the decimals they are written as. This is an independent check of the program: it shares no
code with it and is not needed to build or test it. It needs Python >= 3.11 and mpmath. Scenes of n coordinates have
scene_expectations.py.

    python3 scripts/expectations.py [--write] [CASE ...]        default: all of cases/ but the scenes

Prints t_final and x_final of every case and compares them with its [expect] table; the exit code is 1 if a number
differs by more than the table's tolerance or a case has no solution. --write replaces everything after the line
[expect], which must be the last table of its file, by the numbers found.
"""

import argparse
import ast
import operator
import re
import sys
import tomllib
from fractions import Fraction as F
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 100
ACCURACY = mpf("1e-85")
MOST_WINDOWS = 10_000  # more are too many to solve here
TOLERANCE = "1e-11"  # written by --write; for a case of more than 16 digits all but two of them

# Rows of D for unit spacing: left closure (the right one is its mirror image with the sign changed), interior stencil.
SBP = {
    "SBP21": ([[F(-1), F(1)]], {-1: F(-1, 2), 1: F(1, 2)}),
    "SBP42": (
        [
            [F(-24, 17), F(59, 34), F(-4, 17), F(-3, 34)],
            [F(-1, 2), F(0), F(1, 2)],
            [F(4, 43), F(-59, 86), F(0), F(59, 86), F(-4, 43)],
            [F(3, 98), F(0), F(-59, 98), F(0), F(32, 49), F(-4, 49)],
        ],
        {-2: F(1, 12), -1: F(-2, 3), 1: F(2, 3), 2: F(-1, 12)},
    ),
}


OPERATIONS = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.Pow: operator.pow, ast.USub: operator.neg, ast.UAdd: operator.pos},
}
FUNCTIONS = "sin cos tan sinh cosh tanh asin acos atan exp ln log10 sqrt".split()
FUNCTIONS = {name: getattr(mp, name) for name in FUNCTIONS} | {"abs": abs}


def number(value):
    return mpf(value)


def load(text):
    """A case with its numbers as they are written."""
    return tomllib.loads(text, parse_float=str)


def formula(expression, parameters={}):
    """V(x). The grammar is Python's with ^ in place of **."""
    # Every name gets an underscore at its end, so that a parameter may be called lambda.
    python = re.sub(r"(?<![\w.])[A-Za-z_]\w*", r"\g<0>_", expression).replace("^", "**")
    tree = ast.parse(f"({python})", mode="eval").body
    constants = {name + "_": number(value) for name, value in parameters.items()} | {"pi_": mp.pi}

    def evaluate(node, x):
        match node:
            case ast.Constant():
                return number(ast.get_source_segment(f"({python})", node))
            case ast.Name(id=name):
                return x if name == "x_" else constants[name]
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return FUNCTIONS[name[:-1]](evaluate(argument, x))
            case ast.UnaryOp(op=op, operand=u):
                return OPERATIONS[type(op)](evaluate(u, x))
            case ast.BinOp(left=u, op=op, right=v):
                return OPERATIONS[type(op)](evaluate(u, x), evaluate(v, x))
        raise ValueError(f"not understood: {expression}")

    return lambda x: evaluate(tree, x)


def polynomial(coefficients):
    return lambda x: mp.polyval([number(c) for c in reversed(coefficients)], x)


POTENTIALS = {
    "free": lambda: polynomial([0]),
    "linear": lambda alpha: polynomial([0, alpha]),
    "quartic": lambda kappa: polynomial([0, 0, 0, 0, kappa]),
    "polynomial": polynomial,
    "formula": formula,
}


def with_derivatives(f, x):
    """f, f' and f'' at x by central differences: in 250 digits and with this step they are exact to 85 digits."""
    with mp.workdps(250):
        step = mpf("1e-45") * max(1, abs(x))
        left, middle, right = f(x - step), f(x), f(x + step)
        return middle, (right - left) / (2 * step), (right - 2 * middle + left) / step**2


def lobatto_nodes(n):
    """The Gauss-Lobatto-Legendre nodes on [-1, 1]: the ends and the zeros of P'_(n-1)."""
    m, (before, now) = n - 1, ([mpf(1)], [mpf(0), mpf(1)])  # coefficients, lowest first
    for k in range(1, m):
        shifted = [mpf(0)] + [(2 * k + 1) * c for c in now]
        shifted[: len(before)] = (a - k * b for a, b in zip(shifted, before))
        before, now = now, [c / (k + 1) for c in shifted]
    slope = [k * c for k, c in enumerate(now)][1:]
    inner = mp.polyroots(slope[::-1], maxsteps=200, extraprec=400) if m > 1 else []
    return [mpf(-1), *sorted(inner), mpf(1)]


def lobatto_rows(n, length):
    """All rows of D through these nodes, by differentiating Lagrange polynomials, and 1/H_1 = n (n - 1) / length."""
    z = lobatto_nodes(n)
    others = [mp.fprod(z[j] - z[k] for k in range(n) if k != j) for j in range(n)]
    entry = lambda i, j: others[i] / others[j] / (z[i] - z[j])
    rows = [{j: 2 / length * entry(i, j) for j in range(n) if j != i} for i in range(n)]
    for i, row in enumerate(rows):
        row[i] = -mp.fsum(row.values())  # constants have no derivative
    return rows, n * (n - 1) / length


def derivative_rows(name, n, h, form):
    """The first N-1 rows of D (strong form) or all of D + H^-1 e_1 e_1^T (weak), as {column: coefficient}; 1/H_1."""
    if name.startswith("GLL"):
        rows, penalty = lobatto_rows(n, h * (n - 1))
        if form == "weak":
            rows[0][0] += penalty
        else:
            rows.pop()
        return rows, penalty
    closure, interior = SBP[name]
    left = [dict(enumerate(row)) for row in closure]
    middle = [{k + m: d for m, d in interior.items()} for k in range(len(left), n - len(left))]
    right = [{n - 1 - j: -d for j, d in row.items()} for row in reversed(left)]
    rows = left + middle + right
    penalty = -2 * rows[0][0]  # H_1 D_11 = Q_11 = -1/2 by the SBP property
    if form == "weak":
        rows[0][0] += penalty
    else:
        rows.pop()
    scaled = lambda d: mpf(d.numerator) / (d.denominator * h)
    return [{j: scaled(d) for j, d in row.items() if d} for row in rows], scaled(penalty)


def solve_banded(rows, rhs):
    """Gaussian elimination with partial pivoting; rows are {column: value}. Overwrites both arguments."""
    n = len(rows)
    lower = max(i - min(row) for i, row in enumerate(rows))
    for p in range(n):
        below = range(p + 1, min(n, p + lower + 1))
        best = max((p, *below), key=lambda i: abs(rows[i].get(p, 0)))
        rows[p], rows[best], rhs[p], rhs[best] = rows[best], rows[p], rhs[best], rhs[p]
        for i in below:
            if p in rows[i]:
                factor = rows[i].pop(p) / rows[p][p]
                for j, a in rows[p].items():
                    if j > p:
                        rows[i][j] = rows[i].get(j, 0) - factor * a
                rhs[i] -= factor * rhs[p]
    for p in reversed(range(n)):
        rhs[p] = (rhs[p] - sum(a * rhs[j] for j, a in rows[p].items() if j > p)) / rows[p][p]
    return rhs


class Geodesic:
    """The collocation system of one case."""

    def __init__(self, case):
        particle, initial, grid = case.get("particle", {}), case["initial"], case["grid"]
        ((kind, values),) = case["potential"].items()
        self.potential = POTENTIALS[kind](**values)
        self.mass, self.c = number(particle.get("mass", 1)), number(particle.get("c", 1))
        self.t_i, self.x_i, t_dot = (number(initial[key]) for key in ("t", "x", "t_dot"))
        self.x_dot = number(initial["x_dot"]) if "x_dot" in initial else number(initial["velocity"]) * t_dot
        self.gamma_i, scheme, windows = number(grid.get("gamma_i", 0)), case.get("scheme", {}), grid.get("windows", 1)
        if "accuracy" in case.get("solver", {}):
            # What an accuracy is one of: the continuum, here to some 25 digits.
            length = number(grid["t_f"]) - self.t_i if "t_f" in grid else number(grid.get("gamma_f", 1)) - self.gamma_i
            scheme, windows = {"sbp": "GLL24", "form": "weak"}, int(mp.ceil(2 * length))
        self.whole = mpf(0)  # of gamma in whole periods, and their time
        self.q = self.g00(self.x_i)[0] * t_dot
        if windows > MOST_WINDOWS:
            # As fine as this the continuum is meant: the particle is where it was whole periods before.
            period, self.whole_time = self.period()
            length = number(grid.get("gamma_f", 1)) - self.gamma_i
            self.whole = mp.floor(length / period) * period
            self.whole_time *= mp.floor(length / period)
            scheme, windows = {"sbp": "GLL24", "form": "weak"}, int(mp.ceil(4 * (length - self.whole)))
        self.sbp = scheme["sbp"]
        self.n = grid.get("n_gamma") or int(self.sbp.removeprefix("GLL"))
        if self.whole:
            self.n = 24
        self.windows, self.form = windows, scheme.get("form", "strong")

    def g00(self, x):
        """g00 and its first two derivatives."""
        v, dv, ddv = with_derivatives(self.potential, x)
        g = self.c**2 + 2 * v / self.mass
        if not g > 0:
            raise ArithmeticError("outside the domain g00 > 0")
        return g, 2 * dv / self.mass, 2 * ddv / self.mass

    def rates(self, x):
        """dt/dgamma, dw/dgamma and the derivative of the latter by x."""
        g, dg, ddg = self.g00(x)
        t_dot = self.q / g
        return t_dot, -dg * t_dot**2 / 2, (dg**2 / g - ddg / 2) * t_dot**2

    def period(self):
        """The period in gamma and in t, from dx/dgamma = sqrt(Q^2/g00 - K) between the turning points.

        With x = middle + half sin(s) the integrands are analytic and periodic in s: the midpoint rule converges
        exponentially.
        """
        k = self.q**2 / self.g00(self.x_i)[0] - self.x_dot**2
        square = lambda x: self.q**2 / self.g00(x)[0] - k
        turns = []
        for sign in (1, -1):
            step = mpf("0.01") * sign
            # Beyond a turning point the square is negative; at rest the start is one.
            inside = self.x_i if square(self.x_i + step) > 0 else None
            if inside is None:
                turns.append(self.x_i)
                continue
            while square(inside + step) > 0:
                inside += step
            turns.append(mp.findroot(square, (inside, inside + step), solver="anderson", tol=ACCURACY**2))
        middle, half, points = (turns[0] + turns[1]) / 2, (turns[0] - turns[1]) / 2, 200
        gamma = time = mpf(0)
        for j in range(points):
            s = 2 * mp.pi * (j + mpf("0.5")) / points
            x = middle + half * mp.sin(s)
            pace = abs(half * mp.cos(s)) / mp.sqrt(square(x)) * 2 * mp.pi / points
            gamma += pace
            time += pace * self.rates(x)[0]
        return gamma, time

    def solve(self, gamma_f):
        """t_N and x_N."""
        if self.whole:
            whole, self.whole = self.whole, mpf(0)
            t, x = self.solve(gamma_f - whole)
            return t + self.whole_time, x
        h = (gamma_f - self.gamma_i) / (self.n - 1) / self.windows
        explicit = (self.sbp, self.form) == ("SBP21", "strong")
        state = self.t_i, self.x_i, self.x_dot
        for _ in range(self.windows):
            state = self.march(h, *state) if explicit else self.collocate(h, *state)
        return state[:2]

    def solve_until(self, t_f):
        """gamma_f, t_N and x_N such that t_N = t_f, by the secant method."""
        gamma, last = self.gamma_i + (t_f - self.t_i) * self.g00(self.x_i)[0] / self.q, None
        for _ in range(50):
            t, x = self.solve(gamma)
            excess = t - t_f
            if abs(excess) < ACCURACY:
                return gamma, t, x
            slope = (excess - last[1]) / (gamma - last[0]) if last else self.rates(x)[0]
            last, gamma = (gamma, excess), gamma - excess / slope
        raise ArithmeticError("no gamma_f found for this t_f")

    def march(self, h, *start):
        """SBP21 from (t, x, w): an Euler step, then leapfrog."""
        before = now = start
        for k in range(self.n - 1):
            t_dot, w_dot, _ = self.rates(now[1])
            step = 2 * h if k else h
            before, now = now, tuple(u + step * du for u, du in zip(before, (t_dot, now[2], w_dot)))
        return now

    def collocate(self, h, t_i, x_i, w_i):
        """From (t, x, w) Newton's method for x and w on all nodes; t follows from a linear system."""
        d, penalty = derivative_rows(self.sbp, self.n, h, self.form)
        # The first unknown node, counted from 0, and what the initial values add to the first row.
        first, x_start, w_start = 1, 0, 0
        if self.form == "weak":
            first, x_start, w_start = 0, penalty * x_i, penalty * w_i
        x, w = self.first_guess(h, x_i, w_i)
        for _ in range(50):
            # Unknowns x_2, w_2, x_3, w_3, ... (weak form: from node 1); node j, counted from 0, has the columns
            # 2 (j - first) and 2 (j - first) + 1.
            jacobian, residual = [], []
            for k, row in enumerate(d):
                _, w_dot, dw_dot = self.rates(x[k])
                x_row = {2 * (j - first): a for j, a in row.items() if j >= first}
                w_row = {2 * (j - first) + 1: a for j, a in row.items() if j >= first}
                if k >= first:
                    x_row[2 * (k - first) + 1], w_row[2 * (k - first)] = mpf(-1), -dw_dot
                jacobian += x_row, w_row
                residual += sum(a * x[j] for j, a in row.items()) - w[k], sum(a * w[j] for j, a in row.items()) - w_dot
            residual[0] -= x_start
            residual[1] -= w_start
            step = solve_banded(jacobian, residual)
            x[first:] = (u - du for u, du in zip(x[first:], step[0::2]))
            w[first:] = (u - du for u, du in zip(w[first:], step[1::2]))
            if max(map(abs, step)) < ACCURACY * max(1, *map(abs, x)):
                break
        else:
            raise ArithmeticError("Newton's method did not converge")
        t_dot = [self.rates(u)[0] for u in x]
        rows = [{j - first: a for j, a in row.items() if j >= first} for row in d]
        elapsed = solve_banded(rows, t_dot[: len(rows)])
        return t_i + elapsed[-1], x[-1], w[-1]

    def first_guess(self, h, x_i, w_i, substeps=8):
        """x and w = dx/dgamma on the nodes by the classical Runge-Kutta method, in double precision."""
        x, w = [x_i], [w_i]
        nodes = [mpf(k) for k in range(self.n)]
        if self.sbp.startswith("GLL"):
            nodes = [(z + 1) / 2 * (self.n - 1) for z in lobatto_nodes(self.n)]
        with mp.workdps(15):
            u, v = x_i, w_i
            for i in range(substeps * (self.n - 1)):
                k = i // substeps
                s = (nodes[k + 1] - nodes[k]) * h / substeps
                u1, v1 = v, self.rates(u)[1]
                u2, v2 = v + s / 2 * v1, self.rates(u + s / 2 * u1)[1]
                u3, v3 = v + s / 2 * v2, self.rates(u + s / 2 * u2)[1]
                u4, v4 = v + s * v3, self.rates(u + s * u3)[1]
                u, v = u + s / 6 * (u1 + 2 * u2 + 2 * u3 + u4), v + s / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
                if i % substeps == substeps - 1:
                    x.append(u)
                    w.append(v)
        return x, w


def check(path, write):
    """Prints the line of one case; true if nothing differs."""
    text = path.read_text(encoding="utf-8")
    head, _, tail = re.split(r"(?m)^(\[expect\].*)$", text) if "\n[expect]" in text else (text, "", "")
    case, expect = load(head), {}
    try:
        expect = load(tail)
    except tomllib.TOMLDecodeError:
        pass  # a placeholder, to be written
    status, regularised = expect.get("status", "converged"), case.get("scheme", {}).get("regularised", True)
    if status != "converged" or not regularised:
        print(f"{path.stem:22} skipped: {f'status {status} expected' if regularised else 'action not regularised'}")
        return True
    grid, comment = case["grid"], ""
    try:
        geodesic = Geodesic(case)
        if "t_f" in grid:
            gamma_f, t, x = geodesic.solve_until(number(grid["t_f"]))
            comment = f" gamma_f = {mp.nstr(gamma_f, 20)}"
        else:
            t, x = geodesic.solve(number(grid.get("gamma_f", 1)))
    except (ArithmeticError, TypeError) as error:  # TypeError: a complex number in a formula
        print(f"{path.stem:22} FAILED: {error}")
        return False
    found = {"t_final": t, "x_final": x}
    differences = [abs(value - number(expect[name])) for name, value in found.items() if name in expect]
    ok = all(difference <= number(expect.get("tolerance", TOLERANCE)) for difference in differences)
    verdict = f" difference {mp.nstr(max(differences), 2)} {'ok' if ok else 'DIFFERS'}" if differences else ""
    line = "".join(f" {name} = {mp.nstr(value, 20):23}" for name, value in found.items())
    print(f"{path.stem:22}{line}{verdict}{comment}")
    if write:
        digits = case.get("solver", {}).get("digits", 16)
        tolerance = TOLERANCE if digits == 16 else f"1e-{digits - 2}"
        numbers = "".join(f"{name} = {mp.nstr(value, digits)}\n" for name, value in found.items())
        header = text[len(head) : len(text) - len(tail)] or "\n[expect]"
        path.write_text(f"{head}{header}\n{numbers}tolerance = {tolerance}\n", encoding="utf-8")
    return ok or write


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the numbers into the [expect] tables")
    parser.add_argument("cases", metavar="CASE", nargs="*", type=Path, help="case files (default: all but scenes)")
    arguments = parser.parse_args()
    folder = Path(__file__).resolve().parent.parent / "cases"
    cases = arguments.cases or sorted(path for path in folder.rglob("*.toml") if path.parent.name != "scenes")
    results = [check(path, arguments.write) for path in cases]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
