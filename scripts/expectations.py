#!/usr/bin/env python3
"""Reference values for the [expect] tables of the case files.

A metric, or a potential V in the paper's metric (c^2 + 2 V/m, -1, ...), has Hamilton's equations,

    dq^a/dgamma = g^ab (p_b - A_b),   dp_a/dgamma = dL/dq^a + F_a,   L = 1/2 g_ab q_dot^a q_dot^b + A_a q_dot^a,

with derivatives by a complex step through the formulas of the case. Newton's law is integrated as such, m d2x/dt2 =
-dV/dx + F, in time, with s as the integral of 1/2 m v^2 - V + A v. A conformal factor multiplies the metric after the
start was found without it; a start with K other than 0 gets the flat coordinate tau with dtau/dgamma = sqrt(|K|).

With SBP operators the value is the critical point itself: Newton's method solves the collocation system (D y)_k =
rates(y_k) of all q and p in 100 digits, with D in exact rationals. In the weak form D + H^-1 e_1 e_1^T takes the place
of D, H^-1 e_1 times the initial value is added on the right-hand sides, and the equations hold at all nodes. For
spectral elements and for accuracies it is that of the continuum to some 24 digits, by the extrapolated midpoint rule of
Gragg, Bulirsch and Stoer in 40 digits. Numbers are the decimals that a case has.

This shares no code with the program and is not needed to build or test it. It needs Python >= 3.11 and mpmath.

    scripts/expectations.py [--write] [CASE ...]        default: all of cases/

Prints the coordinates at the end of every case and compares them with its [expect] table. The exit code is 1 if a
number differs by more than the table's tolerance or a case has no solution. --write replaces everything after the line
[expect], which must be the last table of its file, by the numbers found, and keeps the tolerance.
"""

import argparse
import ast
import operator
import re
import sys
import tomllib
from fractions import Fraction as F
from pathlib import Path
from types import SimpleNamespace

from mpmath import mp, mpc, mpf

CASES = Path(__file__).resolve().parent.parent / "cases"
DIGITS, TOLERANCE = 40, mpf("1e-26")  # of the integrator: its arithmetic, and the relative error of a step
COLUMNS = 14  # of the extrapolation, which has twice this order
COLLOCATION_DIGITS = 100
COMPLEX_STEP = mpf("1e-60")
WRITTEN_TOLERANCE = "1e-10"  # for a case of more than 16 digits all but two of them
MOST_WINDOWS = 10_000  # of a run longer than these only the whole periods are counted

# Coordinates, definitions and components (the upper triangle). Units with G = c = 1.
PRESETS = {
    "schwarzschild": (["t", "r", "phi"], {}, {"t t": "(r - 2*m)/r", "r r": "-r/(r - 2*m)", "phi phi": "-r*r"}),
    "schwarzschild-ef": (["v", "r", "phi"], {}, {"v v": "(r - 2*m)/r", "v r": "-1", "phi phi": "-r*r"}),
    # delta/rho2 (dt - a sin^2 dphi)^2 - sin^2/rho2 ((r^2 + a^2) dphi - a dt)^2 - rho2/delta dr^2 - rho2 dtheta^2
    "kerr": (
        ["t", "r", "theta", "phi"],
        {
            "rho2": "r^2 + (a*cos(theta))^2",
            "delta": "r^2 - 2*m*r + a^2",
            "ss": "1 - cos(theta)^2",
            "big": "r^2 + a^2",
        },
        {
            "t t": "(delta - a^2*ss)/rho2",
            "t phi": "a*ss*(big - delta)/rho2",
            "r r": "-rho2/delta",
            "theta theta": "-rho2",
            "phi phi": "(delta*a^2*ss^2 - ss*big^2)/rho2",
        },
    ),
    "kerr-equatorial": (
        ["t", "r", "phi"],
        {"delta": "r^2 - 2*m*r + a^2", "big": "r^2 + a^2"},
        {
            "t t": "(delta - a^2)/r^2",
            "t phi": "a*(big - delta)/r^2",
            "r r": "-r^2/delta",
            "phi phi": "(delta*a^2 - big^2)/r^2",
        },
    ),
    "flrw": (["t", "x", "y", "z"], {}, {"t t": "1", "x x": "-a^2", "y y": "-a^2", "z z": "-a^2"}),
    "optics": (["x", "y"], {}, {"x x": "n*n", "y y": "n*n"}),
}
DEFAULTS = dict.fromkeys(["schwarzschild", "schwarzschild-ef"], {"m": 1})
DEFAULTS |= dict.fromkeys(["kerr", "kerr-equatorial"], {"m": 1, "a": 0})


def read(case):
    """The formulas of a case as texts: all components, the potential under Newton's law, what else there is,
    and the initial data."""
    if "body" in case:
        case = of_bodies(case)
    particle, initial, metric = case.get("particle", {}), dict(case["initial"]), case.get("metric")
    table = SimpleNamespace(initial=initial, grid=case["grid"], definitions={}, masses={}, potential=None)
    table.law = "metric" if metric else particle.get("law", "relativistic")
    # A force alone is Newton's law with V = 0.
    spec = metric or case.get("potential", {}) | ({"force": case["force"]} if "force" in case else {})
    if metric:
        preset = metric.get("preset")
        coordinates, table.definitions, components = PRESETS.get(preset, (metric.get("coordinates"), {}, {}))
        table.definitions = table.definitions | metric.get("definitions", {})
        table.components = components | metric.get("components", {})
        table.parameters = DEFAULTS.get(preset, {}) | case.get("parameters", {})
    else:
        names, formula = spec.get("coordinates", ["x"]), spec.get("formula")
        if table.law == "newtonian" and not any(kind in spec for kind in ("formula", *KINDS)):
            names, formula = spec.get("coordinates", list(spec["force"])), "0"
        table.definitions = spec.get("definitions", {})
        if isinstance(formula, dict):
            formula = formula["expression"]
        table.potential, table.parameters = formula or polynomial(spec), case.get("parameters", {})
        mass, c = particle.get("mass", 1), particle.get("c", 1)
        table.masses = particle.get("masses", dict.fromkeys(names, mass))
        # L = 1/2 (c^2 + 2 V/m) t_dot^2 - 1/2 (m_a/m) q_dot^a q_dot^a: minus Newton's L, in units of m, for large c.
        table.components = {"t t": f"({c})^2 + 2/({mass})*({table.potential})"}
        table.components |= {f"{name} {name}": f"-({table.masses[name]})/({mass})" for name in names}
        coordinates = ["t", *names, "s"] if table.law == "newtonian" else ["t", *names]
        if "velocity" in initial:
            initial["x_dot"] = f"({initial['velocity']})*({initial['t_dot']})"
    table.coordinates = coordinates
    table.one_form, table.force = spec.get("one_form", {}), spec.get("force", {})
    table.conformal = spec.get("conformal")
    return table


def of_bodies(case):
    """The same case with a potential in the coordinates of all bodies. One without mass moves no other."""
    bodies, axes = case["body"], "xyz"[: len(case["body"][0]["position"])]
    mass = {body["name"]: "1e-60" if body["mass"] in (0, "0.0") else f"({body['mass']})" for body in bodies}
    terms, word = [], lambda text, names: re.sub(r"\b(r|m_1|m_2)\b", lambda found: names[found[0]], text)
    for j, one in enumerate(body["name"] for body in bodies):
        for two in (body["name"] for body in bodies[:j]):
            distance = "sqrt(" + " + ".join(f"({axis}_{one} - {axis}_{two})^2" for axis in axes) + ")"
            terms.append(word(case["pair"]["formula"], {"r": distance, "m_1": mass[one], "m_2": mass[two]}))
    initial = {"t": case.get("initial", {}).get("t", 0)}
    for body in bodies:
        for axis, place, speed in zip(axes, body["position"], body["velocity"]):
            initial |= {f"{axis}_{body['name']}": place, f"{axis}_{body['name']}_dot": speed}
    names = [f"{axis}_{body['name']}" for body in bodies for axis in axes]
    potential = {"coordinates": names, "formula": " + ".join(f"({term})" for term in terms)}
    particle = {"law": "newtonian", "masses": {name: mass[name[2:]] for name in names}}
    return case | {"potential": potential, "particle": particle, "initial": initial}


KINDS = ("free", "linear", "quartic", "polynomial")


def polynomial(spec):
    """The formula of a potential that has a name."""
    kind = next(kind for kind in KINDS if kind in spec)
    values = spec[kind]
    coefficients = {"free": [], "linear": [0, values.get("alpha")], "quartic": [0] * 4 + [values.get("kappa")]}
    terms = enumerate(coefficients.get(kind, values.get("coefficients")))
    return " + ".join(["0", *(f"({c})" + (f"*x^{k}" if k > 1 else "*x" * k) for k, c in terms if c)])


NAMES = "sin cos tan sinh cosh tanh asin acos atan exp sqrt".split()
FUNCTIONS = {name: getattr(mp, name) for name in NAMES} | {"ln": mp.ln, "log": mp.ln, "log10": mp.log10}
FUNCTIONS["abs"] = lambda u: -u if mp.re(u) < 0 else u  # also beside the real line
OPERATIONS = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.Pow: operator.pow, ast.USub: operator.neg, ast.UAdd: operator.pos},
}
EXACT = (FUNCTIONS, mpf, OPERATIONS)


def parse(text, arithmetic=EXACT):
    """A function of a table of names, and which names it needs. The grammar is Python's with ^ in place of **."""
    functions, number, operations = arithmetic
    # Every name gets an underscore at its end, so that one may be called lambda.
    python = "(" + re.sub(r"(?<![\w.])[A-Za-z_]\w*", r"\g<0>_", str(text)).replace("^", "**") + ")"
    used = set()

    def walk(node):
        match node:
            case ast.Constant():
                value = number(ast.get_source_segment(python, node))
                return lambda names: value
            case ast.Name(id=name):
                name = name[:-1]
                used.add(name)
                return lambda names: names[name]
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                function, u = functions[name[:-1]], walk(argument)
                return lambda names: function(u(names))
            case ast.UnaryOp(op=op, operand=operand):
                operation, u = operations[type(op)], walk(operand)
                return lambda names: operation(u(names))
            case ast.BinOp(left=left, op=op, right=right):
                operation, u, v = operations[type(op)], walk(left), walk(right)
                return lambda names: operation(u(names), v(names))
        raise ValueError(f"not understood: {text}")

    return walk(ast.parse(python, mode="eval").body), used


def in_order(texts, arithmetic=EXACT):
    """Names, functions and what these need, in an order in which each has those that it needs."""
    waiting = {name: parse(text, arithmetic) for name, text in texts.items()}
    while waiting:
        for name in [name for name, (_, used) in waiting.items() if not used & waiting.keys()]:
            yield name, *waiting.pop(name)


class Formulas:
    """Parameters, definitions and formulas of a table."""

    def __init__(self, table, coordinates, arithmetic=EXACT):
        self.arithmetic, self.coordinates, self.parameters = arithmetic, coordinates, {"pi": +mp.pi}
        for name, function, _ in in_order(table.parameters):
            self.parameters[name] = arithmetic[1](function(self.parameters))
        self.definitions, self.depends = {}, {}
        for name, function, used in in_order(table.definitions, arithmetic):
            self.definitions[name] = function
            self.depends[name] = used.union(*(self.depends.get(one, ()) for one in used))

    def formula(self, text):
        """A function of the names, and the coordinates that it depends on."""
        function, used = parse(text, self.arithmetic)
        return function, used.union(*(self.depends.get(name, ()) for name in used)) & set(self.coordinates)

    def number(self, text):
        return parse(text)[0](self.parameters)

    def names(self, q, more={}):
        names = self.parameters | dict(zip(self.coordinates, q)) | more
        for name, function in self.definitions.items():
            names[name] = function(names)
        return names

    def shifted(self, q, a, more={}):
        """The names for a derivative by q^a, which is the imaginary part of a formula over COMPLEX_STEP."""
        return self.names([mpc(u, COMPLEX_STEP) if b == a else u for b, u in enumerate(q)], more)


def solve_dense(rows, rhs):
    return solve_banded([{j: a for j, a in enumerate(row) if a} for row in rows], rhs)


def solve_banded(rows, rhs):
    """Gaussian elimination with partial pivoting; rows are {column: value}. Overwrites both arguments."""
    n = len(rows)
    lower = max((i - min(row) for i, row in enumerate(rows)), default=0)
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


class Motion:
    """A case whose state begins with its coordinates."""

    def velocity(self, y):
        return self.rates(y)[: len(self.coordinates)]

    def values(self, y):
        """What formulas of a case may use: parameters, coordinates and their rates."""
        rates = {f"{name}_dot": rate for name, rate in zip(self.coordinates, self.velocity(y))}
        return self.formulas.parameters | dict(zip(self.coordinates, y)) | rates


class Hamiltonian(Motion):
    """A case with a metric, or with a potential in the paper's metric. Its state is all q, then all p."""

    def __init__(self, case):
        table = read(case)
        self.coordinates, self.has_potential = table.coordinates, table.potential is not None
        self.formulas = Formulas(table, self.coordinates)
        index = self.coordinates.index
        self.set_components(table.components)
        self.one_form = {index(a): self.formulas.formula(text) for a, text in table.one_form.items()}
        self.forces = {index(a): self.formulas.formula(text)[0] for a, text in table.force.items()}
        q, p, self.k = self.start(table.initial)
        if table.conformal:
            components = table.components
            if abs(self.k) > mpf("1e-15"):  # the data of a case may have 16 digits only
                # A particle with K other than 0 is one with K = 0 where the metric gets -d tau^2 or d tau^2.
                sign = -1 if self.k > 0 else 1
                self.coordinates = self.formulas.coordinates = [*self.coordinates, "tau"]
                components = components | {"tau tau": sign}
                q, p = [*q, mpf(0)], [*p, sign * mp.sqrt(abs(self.k))]
            self.set_components({pair: f"({table.conformal})*({text})" for pair, text in components.items()})
        self.state = q + p

    def set_components(self, components):
        """Components by their places, with the upper triangle only."""
        pairs = {tuple(sorted(map(self.coordinates.index, key.split()))): text for key, text in components.items()}
        self.components = {pair: self.formulas.formula(text) for pair, text in pairs.items()}

    def metric(self, names):
        """g as a matrix, and A."""
        n = len(self.coordinates)
        matrix = [[mpf(0)] * n for _ in range(n)]
        for (a, b), (formula, _) in self.components.items():
            matrix[a][b] = matrix[b][a] = formula(names)
        if self.has_potential and not matrix[0][0] > 0:
            raise ArithmeticError("outside the domain g00 > 0")
        return matrix, [self.one_form[a][0](names) if a in self.one_form else mpf(0) for a in range(n)]

    def rates(self, y):
        n = len(self.coordinates)
        q, p = y[:n], y[n:]
        names = self.formulas.names(q)
        matrix, one_form = self.metric(names)
        q_dot = solve_dense(matrix, [u - v for u, v in zip(p, one_form)])
        p_dot = [mpf(0)] * n
        for a, name in enumerate(self.coordinates):
            terms = [(f, q_dot[b] * q_dot[c] / (1 + (b == c))) for (b, c), f in self.components.items()]
            terms += [(f, q_dot[b]) for b, f in self.one_form.items()]
            terms = [(formula, factor) for (formula, depends), factor in terms if name in depends]
            shifted = self.formulas.shifted(q, a) if terms else None
            p_dot[a] = sum((mp.im(formula(shifted)) / COMPLEX_STEP * factor for formula, factor in terms), mpf(0))
            if a in self.forces:
                p_dot[a] += self.forces[a](names | {f"{one}_dot": u for one, u in zip(self.coordinates, q_dot)})
        return q_dot + p_dot

    def start(self, initial):
        """q, p and K: momenta that are given, and one rate from K, determine the rest."""
        number, names, n = self.formulas.number, self.coordinates, len(self.coordinates)
        q = [number(initial.get(name, 0)) for name in names]
        matrix, one_form = self.metric(self.formulas.names(q))
        ((solved, sign),) = initial.get("solve", {"": ""}).items()
        is_momentum = [f"p_{name}" in initial or solved == f"p_{name}" for name in names]
        given = [number(initial.get(f"p_{name}", initial.get(f"{name}_dot", 0))) for name in names]
        unknown, known = ([a for a in range(n) if is_momentum[a] == wanted] for wanted in (True, False))

        def velocities(given, one_form):
            rows = [[matrix[a][b] for b in unknown] for a in unknown]
            rhs = [given[a] - one_form[a] - sum(matrix[a][b] * given[b] for b in known) for a in unknown]
            result = list(given)
            for a, value in zip(unknown, solve_dense(rows, rhs)):
                result[a] = value
            return result

        q_dot = velocities(given, one_form)
        form = lambda u, v: sum(u[a] * matrix[a][b] * v[b] for a in range(n) for b in range(n))
        if solved:
            beta = velocities([mpf(solved in (f"p_{name}", f"{name}_dot")) for name in names], [mpf(0)] * n)
            norm = number({"timelike": 1, "null": 0}.get(initial["norm"], initial["norm"]))
            square, middle, rest = form(beta, beta), form(q_dot, beta), form(q_dot, q_dot) - norm
            if square == 0:
                root = -rest / (2 * middle)
            else:
                half = mp.sqrt(middle**2 - square * rest)
                roots = (-middle - half) / square, (-middle + half) / square
                root = max(roots) if sign == "+" else min(roots)
            q_dot = [u + root * v for u, v in zip(q_dot, beta)]
        p = [sum(g * u for g, u in zip(row, q_dot)) + v for row, v in zip(matrix, one_form)]
        return q, p, form(q_dot, q_dot)


class Newtonian(Motion):
    """A case with Newton's law. Its state is t, x, s, then v; the parameter is t, or gamma where t_dot is 1."""

    def __init__(self, case):
        table = read(case)
        self.coordinates, initial = table.coordinates, table.initial
        self.names = names = self.coordinates[1:-1]
        self.formulas = Formulas(table, names)
        number, formula = self.formulas.number, self.formulas.formula
        self.potential = formula(table.potential)[0]
        self.one_form, self.forces = (
            {names.index(a): formula(text)[0] for a, text in texts.items()} for texts in (table.one_form, table.force)
        )
        self.masses = [formula(table.masses[name])[0] for name in names]
        at_start = self.formulas.parameters | {"t": number(initial.get("t", 0))}
        momenta = {name: initial[f"p_{name}"] for name in names if f"p_{name}" in initial}
        if number(initial.get("t_dot", 1)) != 1 or (self.one_form and momenta):
            raise ValueError("only with t_dot = 1, and with a one-form only from velocities")
        if table.conformal and "t_f" not in table.grid:
            raise ValueError("conformal needs an end in t")
        self.state = [number(initial.get(name, 0)) for name in self.coordinates] + [
            number(momenta[name]) / mass(at_start) if name in momenta else number(initial[f"{name}_dot"])
            for name, mass in zip(names, self.masses)
        ]

    def rates(self, y):
        n = len(self.names)
        x, v = y[1 : n + 1], y[n + 2 :]
        names, acceleration = self.formulas.names(x, {"t": y[0]}), []
        shifted = [self.formulas.shifted(x, a, {"t": y[0]}) for a in range(n)]
        later = {"t": mpc(y[0], COMPLEX_STEP)}
        masses = [mass(names) for mass in self.masses]
        growth = [mp.im(mass(self.formulas.names(x, later))) / COMPLEX_STEP for mass in self.masses]
        slope = lambda formula, a: mp.im(formula(shifted[a])) / COMPLEX_STEP
        for a in range(n):
            force = -slope(self.potential, a) + sum(slope(form, a) * v[b] for b, form in self.one_form.items())
            if a in self.one_form:
                force -= sum(slope(self.one_form[a], b) * v[b] for b in range(n))
            if a in self.forces:
                force += self.forces[a](names | {f"{name}_dot": u for name, u in zip(self.names, v)})
            if a in self.one_form:
                force -= mp.im(self.one_form[a](self.formulas.names(x, later))) / COMPLEX_STEP
            # L = 1/2 m(t) v^2 - V: d(m v)/dt is the force.
            acceleration.append((force - growth[a] * v[a]) / masses[a])
        kinetic = sum(m * u * u for m, u in zip(masses, v)) / 2
        work = sum(formula(names) * v[b] for b, formula in self.one_form.items())
        return [mpf(1), *v, kinetic - self.potential(names) + work, *acceleration]


def extrapolated_step(rates, y, length, columns=COLUMNS):
    """A step of the extrapolated midpoint rule, and how much its last extrapolation changed."""
    slope, table = rates(y), []
    for j in range(1, columns + 1):
        n = 2 * j
        h = length / n
        before, now = y, [u + h * s for u, s in zip(y, slope)]
        for _ in range(n - 1):
            before, now = now, [u + 2 * h * s for u, s in zip(before, rates(now))]
        # Neville's scheme in h^2.
        row = [now]
        for k, old in enumerate(table):
            factor = mpf(j) ** 2 / mpf(j - 1 - k) ** 2 - 1
            row.append([u + (u - v) / factor for u, v in zip(row[k], old)])
        table = row
    change = max(abs(u - v) / max(1, abs(u)) for u, v in zip(table[-1], table[-2]))
    return table[-1], change


def integrate(scene, length, until=None):
    """The state after `length`, or where the function `until` of the state first changes its sign."""
    y, gone, h = scene.state, mpf(0), min(length, mpf("0.5"))
    while gone < length:
        h = min(h, length - gone)
        new, change = extrapolated_step(scene.rates, y, h)
        growth = (TOLERANCE / 100 / max(change, mpf("1e-60"))) ** (mpf(1) / (2 * COLUMNS - 1))
        proposed = h * min(2, max(mpf("0.2"), growth))
        if change > TOLERANCE:
            h = proposed
            continue
        if until:
            here, there = until(y), until(new)
            if here * there < 0 or (there == 0 and here):
                part = lambda share: until(extrapolated_step(scene.rates, y, share * h)[0])
                share = mp.findroot(part, (mpf(0), mpf(1)), solver="anderson", tol=mpf("1e-60"), verify=False)
                return extrapolated_step(scene.rates, y, share * h)[0], gone + share * h
        y, gone, h = new, gone + h, proposed
    return y, gone


def with_events(scene, length, events):
    """The same with the events that act, of Newton's law and of velocities alone, each after the one before."""
    (event,), gone = events, mpf(0)
    when = parse(event["when"])[0]
    sets = {scene.names.index(key.removesuffix("_dot")): parse(text)[0] for key, text in event["set"].items()}
    first = len(scene.coordinates)
    while gone < length:
        y, part = integrate(scene, length - gone, lambda y: when(scene.values(y)))
        gone += part
        if gone < length:
            before, ahead = scene.values(y), extrapolated_step(scene.rates, y, mpf("1e-6"))[0]
            if (when(scene.values(ahead)) < 0) == (event["direction"] == "down"):
                for place, formula in sets.items():
                    y[first + place] = formula(before)
            # The zero itself is left behind.
            y, gone = extrapolated_step(scene.rates, y, mpf("1e-6"))[0], gone + mpf("1e-6")
        scene.state = y
    return y, gone


def without_whole_periods(scene, length):
    """What is left of a length when whole periods of a motion from rest in V(x) are taken out, and their t is put in:
    as long as it takes to rest again, at the other end, it takes to come back."""
    turned, half = integrate(scene, length, lambda y: y[3])
    count = mp.floor(length / (2 * half))
    scene.state = [scene.state[0] + 2 * count * (turned[0] - scene.state[0]), *scene.state[1:]]
    return length - 2 * count * half


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


def derivative_rows(name, n, h, form):
    """The first N-1 rows of D (strong form) or all of D + H^-1 e_1 e_1^T (weak), as {column: coefficient}; 1/H_1."""
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


def first_guess(scene, n, h):
    """The nodes in double precision, step by step."""
    y = [scene.state]
    with mp.workdps(15):
        for _ in range(n - 1):
            y.append(extrapolated_step(scene.rates, y[-1], h, columns=4)[0])
    return y


def collocate(scene, y, d, penalty):
    """The nodes that solve (D y)_k = rates(y_k) over one window, from a guess."""
    n, m, step = len(y), len(scene.state), mpf("1e-45")
    first = n - len(d)  # node whose state is not known; all are unknown in the weak form
    for _ in range(40):
        jacobian, residual = [], []
        for k, row in enumerate(d):
            rates = scene.rates(y[k])
            own = [{m * (j - first) + a: weight for j, weight in row.items() if j >= first} for a in range(m)]
            for b in range(m) if k >= first else ():
                size = step * max(abs(y[k][b]), abs(scene.state[b])) or step
                moved = scene.rates([u + size if a == b else u for a, u in enumerate(y[k])])
                column = m * (k - first) + b
                for a, (u, v) in enumerate(zip(moved, rates)):
                    if u != v:
                        own[a][column] = own[a].get(column, 0) - (u - v) / size
            jacobian += own
            residual += [sum(weight * y[j][a] for j, weight in row.items()) - rates[a] for a in range(m)]
        if first == 0:
            residual[:m] = (u - penalty * v for u, v in zip(residual, scene.state))
        change = solve_banded(jacobian, residual)
        for j in range(first, n):
            y[j] = [u - du for u, du in zip(y[j], change[m * (j - first) :])]
        sizes = [max(abs(one[a]) for one in y) or 1 for a in range(m)]
        if max(abs(du) / sizes[k % m] for k, du in enumerate(change)) < mpf("1e-60"):
            return y
    raise ArithmeticError("Newton's method did not converge")


def critical_point(scene, sbp, form, grid, length, t_f):
    """The last node, and its gamma, where an operator's only window ends after `length` or at t_f."""
    n = grid["n_gamma"]
    y = []

    def end(length):
        h = length / (n - 1)
        y[:] = collocate(scene, y or first_guess(scene, n, h), *derivative_rows(sbp, n, h, form))
        return y[-1]

    if t_f is not None:
        length = (t_f - scene.state[0]) / scene.rates(scene.state)[0]
        excess = lambda length: end(length)[0] - t_f
        length = mp.findroot(excess, (length, length * mpf("1.01")), solver="secant", tol=mpf("1e-75"), verify=False)
    return end(length), length


def solve(case):
    """The coordinates at the end, and gamma there."""
    is_newtonian = "body" in case or case.get("particle", {}).get("law") == "newtonian"
    grid, scheme, solver = case["grid"], case.get("scheme", {}), case.get("solver", {})
    is_spectral = {"accuracy", "tolerance"} & solver.keys() or scheme["sbp"].startswith("GLL")
    mp.dps = DIGITS if is_spectral else COLLOCATION_DIGITS
    scene = Newtonian(case) if is_newtonian else Hamiltonian(case)
    number, until = scene.formulas.number, None
    gamma_i = number(grid.get("gamma_i", 0))
    t_f = number(grid["t_f"]) if "t_f" in grid else None
    length = number(grid.get("gamma_f", 1)) - gamma_i
    if is_newtonian and t_f is not None and t_f < scene.state[0]:
        # The way back: all rates have the other sign, and so has the parameter.
        forward, scene.rates = scene.rates, lambda y: [-u for u in forward(y)]
        y, gone = integrate(scene, scene.state[0] - t_f)
        return dict(zip(scene.coordinates, y)), gamma_i - gone
    if not is_spectral:
        if is_newtonian or "until" in grid or grid.get("windows", 1) != 1:
            raise ValueError("an SBP operator only in one window, without until, and not with Newton's law")
        y, gone = critical_point(scene, scheme["sbp"], scheme.get("form", "strong"), grid, length, t_f)
        return dict(zip(scene.coordinates, y)), gamma_i + gone
    if solver.get("digits", 16) > 20:
        raise ValueError("a spectral element only in 20 digits")
    if t_f is not None:
        t = scene.coordinates.index("t")
        # The parameter of Newton's law is t.
        length = t_f - scene.state[0] if is_newtonian else mpf("1e18")
        until = None if is_newtonian else lambda y: y[t] - t_f
    if "until" in grid:
        formula = parse(grid["until"])[0]
        until = lambda y: formula(scene.values(y))
    if acting := [event for event in case.get("events", {}).values() if "set" in event]:
        y, gone = with_events(scene, length, acting)
        return dict(zip(scene.coordinates, y)), gamma_i + gone
    left = without_whole_periods(scene, length) if grid.get("windows", 1) > MOST_WINDOWS else length
    y, gone = integrate(scene, left, until)
    return dict(zip(scene.coordinates, y)), gamma_i + gone + length - left


def check(path, write):
    """Prints the lines of one case; true if nothing differs."""
    text = path.read_text(encoding="utf-8")
    head, _, tail = re.split(r"(?m)^(\[expect\].*)$", text) if "\n[expect]" in text else (text, "", "")
    # Numbers as they are written.
    case, expect = (tomllib.loads(part, parse_float=str) for part in (head, tail))
    status, regularised = expect.get("status", "converged"), case.get("scheme", {}).get("regularised", True)
    reasons = {
        "a kink; its numbers are those of the solution that the file names": re.search(r"\b(sign|step|min|max)\(", head),
        "a function that is a table": "tables" in case,
        f"status {status} expected": status != "converged",
        "action not regularised": not regularised,
    }
    if reason := next((reason for reason, is_one in reasons.items() if is_one), None):
        print(f"{path.stem:22} skipped: {reason}")
        return True
    try:
        position, gamma = solve(case)
    except (ArithmeticError, TypeError, ValueError) as error:
        print(f"{path.stem:22} FAILED: {error}")
        return False
    expected = lambda name: parse(expect[name])[0]({"pi": +mp.pi})
    chosen = [name for name in position if f"{name}_final" in expect] or [name for name in position if name != "s"]
    found = {f"{name}_final": position[name] for name in chosen}
    if "gamma_final" in expect:
        found["gamma_final"] = gamma
    digits = case.get("solver", {}).get("digits", 16)
    tolerance = expect.get("tolerance", WRITTEN_TOLERANCE if digits == 16 else f"1e-{digits - 2}")
    differences = [abs(value - expected(name)) for name, value in found.items() if name in expect]
    ok = all(difference <= mpf(tolerance) for difference in differences)
    verdict = f"difference {mp.nstr(max(differences), 2)} {'ok' if ok else 'DIFFERS'}" if differences else "no [expect]"
    numbers = ", ".join(f"{name} = {mp.nstr(value, 22)}" for name, value in position.items())
    print(f"{path.stem:22} {verdict}\n    {numbers}, gamma = {mp.nstr(gamma, 22)}", flush=True)
    if write:
        lines = "".join(f"{name} = {mp.nstr(value, max(digits, 17))}\n" for name, value in found.items())
        header = text[len(head) : len(text) - len(tail)] or "\n[expect]"
        path.write_text(f"{head}{header}\n{lines}tolerance = {tolerance}\n", encoding="utf-8")
    return ok or write


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the numbers into the [expect] tables")
    parser.add_argument("cases", metavar="CASE", nargs="*", type=Path, help="case files (default: all)")
    arguments = parser.parse_args()
    results = [check(path, arguments.write) for path in arguments.cases or sorted(CASES.rglob("*.toml"))]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
