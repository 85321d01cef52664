#!/usr/bin/env python3
"""Reference values for the [expect] tables of the scenes in cases/scenes/.

For spectral elements in windows, and with an accuracy, the value is that of the continuum, to some 24 digits. Scenes
with a metric, or with a potential in the paper's metric, are integrated as Hamilton's equations,

    dq^a/dgamma = g^ab (p_b - A_b),   dp_a/dgamma = dL/dq^a + F_a,   L = 1/2 g_ab q_dot^a q_dot^b + A_a q_dot^a,

with dL/dq^a by a complex step through the formulas of the case. Scenes with Newton's law are integrated as Newton's
law, m d2x/dt2 = -dV/dx + F, in time, with s as the integral of 1/2 m v^2 - V + A v. The integrator is the extrapolated
midpoint rule of Gragg, Bulirsch and Stoer in 40 digits. A conformal factor multiplies the metric after the start was
found without it; a start with K other than 0 gets the flat coordinate tau with dtau/dgamma = sqrt(|K|). For the SBP
operators the value is the critical point itself: the collocation system (D y)_k = rates(y_k) of all q and p is solved
by Newton's method in 100 digits, with the operators of expectations.py. The metrics that a case names as a preset are
written out here a second time.

Like expectations.py, this shares no code with the program and is not needed to build or test it. It needs Python >=
3.11 and mpmath.

    python3 scripts/scene_expectations.py [--write] [CASE ...]        default: all of cases/scenes/

Prints the coordinates at the end of every scene and compares them with its [expect] table; the exit code is 1 if a
number differs by more than the table's tolerance. --write replaces everything after the line [expect], which must be
the last table of its file, by the numbers found, and keeps the tolerance.
"""

import argparse
import ast
import re
import sys
import tomllib
from pathlib import Path

from mpmath import mp, mpc, mpf

from expectations import FUNCTIONS, derivative_rows, load, solve_banded

DIGITS, TOLERANCE = 40, mpf("1e-26")  # of the integrator: its arithmetic, and the relative error of a step
COLUMNS = 14  # of the extrapolation, which has twice this order
COMPLEX_STEP = mpf("1e-30")
COLLOCATION_DIGITS = 100
WRITTEN_TOLERANCE = "1e-10"

# Coordinates, definitions and components (the upper triangle). Units with G = c = 1.
PRESETS = {
    "schwarzschild": (
        ["t", "r", "phi"],
        {},
        {"t t": "(r - 2*m)/r", "r r": "-r/(r - 2*m)", "phi phi": "-r*r"},
    ),
    "schwarzschild-ef": (
        ["v", "r", "phi"],
        {},
        {"v v": "(r - 2*m)/r", "v r": "-1", "phi phi": "-r*r"},
    ),
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
DEFAULTS = {"schwarzschild": {"m": 1}, "schwarzschild-ef": {"m": 1}, "kerr": {"m": 1}, "kerr-equatorial": {"m": 1}}


class Formula:
    """An expression in names, in the arithmetic of mpmath. The grammar is Python's with ^ in place of **."""

    def __init__(self, text):
        # Every name gets an underscore at its end, so that one may be called lambda.
        python = re.sub(r"(?<![\w.])[A-Za-z_]\w*", r"\g<0>_", str(text)).replace("^", "**")
        tree = ast.parse(f"({python})", mode="eval")
        self.names = {node.id[:-1] for node in ast.walk(tree) if isinstance(node, ast.Name)}
        self.constants = {}
        segment = lambda node: ast.get_source_segment(f"({python})", node)
        for node in list(ast.walk(tree)):
            for field, child in ast.iter_fields(node):
                if isinstance(child, ast.Constant):
                    setattr(node, field, self.constant(segment(child)))
                elif isinstance(child, list):  # the arguments of a function
                    child[:] = [self.constant(segment(u)) if isinstance(u, ast.Constant) else u for u in child]
        self.code = compile(ast.fix_missing_locations(tree), str(text), "eval")

    def constant(self, text):
        name = f"c{len(self.constants)}"
        self.constants[name] = text
        return ast.Name(id=name, ctx=ast.Load())

    def compiled(self):
        """A function of a namespace that has its names with an underscore."""
        constants = {name: mpf(text) for name, text in self.constants.items()}
        functions = {f"{name}_": function for name, function in FUNCTIONS.items()}
        own = constants | functions | {"pi_": +mp.pi, "__builtins__": {}}
        return lambda names: eval(self.code, own, names)  # the text is that of a case file of this project


class Formulas:
    """Parameters, definitions and formulas of a table."""

    def __init__(self, parameters, definitions, coordinates):
        self.parameters, self.coordinates = {}, coordinates
        waiting = dict(parameters)
        for name, text in waiting.items():
            self.parameters[f"{name}_"] = Formula(text).compiled()({})
        # Definitions in an order in which each has those that it uses.
        self.definitions, parsed = [], {name: Formula(text) for name, text in definitions.items()}
        self.depends = {}
        while parsed:
            ready = [name for name, formula in parsed.items() if not formula.names & parsed.keys()]
            for name in ready:
                formula = parsed.pop(name)
                self.depends[name] = formula.names.union(*(self.depends.get(used, ()) for used in formula.names))
                self.definitions.append((f"{name}_", formula.compiled()))
        self.used = set()

    def formula(self, text):
        """A function of a namespace; the coordinates that it depends on are noted."""
        formula = Formula(text)
        self.used |= formula.names.union(*(self.depends.get(name, ()) for name in formula.names))
        return formula.compiled()

    def number(self, text):
        return Formula(text).compiled()(self.parameters)

    def names(self, q):
        names = self.parameters | {f"{name}_": value for name, value in zip(self.coordinates, q)}
        for name, formula in self.definitions:
            names[name] = formula(names)
        return names


def solve_dense(rows, rhs):
    """Gaussian elimination with partial pivoting. Overwrites both arguments."""
    n = len(rows)
    for p in range(n):
        best = max(range(p, n), key=lambda i: abs(rows[i][p]))
        rows[p], rows[best], rhs[p], rhs[best] = rows[best], rows[p], rhs[best], rhs[p]
        for i in range(p + 1, n):
            if rows[i][p]:
                factor = rows[i][p] / rows[p][p]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[p])]
                rhs[i] -= factor * rhs[p]
    for p in reversed(range(n)):
        rhs[p] = (rhs[p] - sum(rows[p][j] * rhs[j] for j in range(p + 1, n))) / rows[p][p]
    return rhs


class Hamiltonian:
    """A scene with a metric, or with a potential in the paper's metric. Its state is all q, then all p."""

    def __init__(self, case):
        self.forces, self.one_form, self.conformal = {}, {}, None
        if "metric" in case:
            self.read_metric(case["metric"])
        else:
            self.read_potential(case["potential"], case.get("particle", {}))
        n = len(self.coordinates)
        self.is_active = [name in self.formulas.used for name in self.coordinates]
        self.gamma_i = self.formulas.number(case["grid"].get("gamma_i", 0))
        factor, self.conformal = self.conformal, None
        q, p, k = self.start(case["initial"], n)
        if factor:
            self.conformal = factor
            if abs(k) > mpf("1e-15"):  # the data of a case may have 16 digits only
                self.add_tau(n, q, p, k)
        self.state = q + p

    def add_tau(self, n, q, p, k):
        """A particle with K other than 0 as one with K = 0: the metric gets -d tau^2 or d tau^2."""
        sign = -1 if k > 0 else 1
        self.coordinates = self.formulas.coordinates = [*self.coordinates, "tau"]
        self.components.append((n, n, lambda names: mpf(sign)))
        self.is_active.append(False)
        q.append(mpf(0))
        p.append(sign * mp.sqrt(abs(k)))

    def read_metric(self, table):
        preset = table.get("preset")
        coordinates, definitions, components = PRESETS[preset] if preset else (table["coordinates"], {}, {})
        parameters = DEFAULTS.get(preset, {}) | table.get("parameters", {})
        if preset and preset.startswith("kerr"):
            parameters = {"a": 0} | parameters
        self.coordinates = coordinates
        self.formulas = Formulas(parameters, definitions | table.get("definitions", {}), coordinates)
        index = lambda name: coordinates.index(name)
        components = components | table.get("components", {})
        pairs = {tuple(sorted(map(index, key.split()))): text for key, text in components.items()}
        self.components = [(a, b, self.formulas.formula(text)) for (a, b), text in pairs.items()]
        if "conformal" in table:
            self.conformal = self.formulas.formula(table["conformal"])
        self.one_form = {index(a): self.formulas.formula(text) for a, text in table.get("one_form", {}).items()}
        self.forces = {index(a): self.formulas.formula(text) for a, text in table.get("force", {}).items()}

    def read_potential(self, table, particle):
        """L = 1/2 (c^2 + 2 V/m) t_dot^2 - 1/2 (m_a/m) q_dot^a q_dot^a: minus Newton's L, in units of m, for large c."""
        names = table.get("coordinates", ["x"])
        self.coordinates = ["t", *names]
        self.formulas = Formulas(table.get("parameters", {}), {}, self.coordinates)
        mass = particle.get("mass", 1)
        masses = particle.get("masses", {name: mass for name in names})
        c, text = particle.get("c", 1), table["formula"]
        self.components = [(0, 0, self.formulas.formula(f"({c})^2 + 2*({text})/({mass})"))]
        for a, name in enumerate(names, 1):
            self.components.append((a, a, self.formulas.formula(f"-({masses[name]})/({mass})")))
        if table.keys() & {"one_form", "force", "conformal"}:
            raise ValueError("only with a metric or with Newton's law")

    def metric(self, names):
        """g as a matrix, and A."""
        n = len(self.coordinates)
        matrix = [[mpf(0)] * n for _ in range(n)]
        factor = self.conformal(names) if self.conformal else 1
        for a, b, formula in self.components:
            matrix[a][b] = matrix[b][a] = factor * formula(names)
        return matrix, [self.one_form[a](names) if a in self.one_form else mpf(0) for a in range(n)]

    def lagrangian(self, q, q_dot):
        names = self.formulas.names(q)
        terms = ((1 if a == b else 2) * formula(names) * q_dot[a] * q_dot[b] for a, b, formula in self.components)
        value = sum(terms) / 2
        if self.conformal:
            value *= self.conformal(names)
        return value + sum(formula(names) * q_dot[a] for a, formula in self.one_form.items())

    def rates(self, y):
        n = len(self.coordinates)
        q, p = y[:n], y[n:]
        names = self.formulas.names(q)
        matrix, one_form = self.metric(names)
        q_dot = solve_dense(matrix, [u - v for u, v in zip(p, one_form)])
        p_dot = []
        for a in range(n):
            force = mpf(0)
            if self.is_active[a]:
                shifted = [mpc(u, COMPLEX_STEP) if b == a else u for b, u in enumerate(q)]
                force = mp.im(self.lagrangian(shifted, q_dot)) / COMPLEX_STEP
            if a in self.forces:
                velocities = {f"{name}_dot_": u for name, u in zip(self.coordinates, q_dot)}
                force += self.forces[a](names | velocities)
            p_dot.append(force)
        return q_dot + p_dot

    def start(self, initial, n):
        """q, p and K: momenta that are given, and one rate from K, determine the rest."""
        number, names = self.formulas.number, self.coordinates
        q = [number(initial.get(name, 0)) for name in names]
        matrix, one_form = self.metric(self.formulas.names(q))
        ((solved, sign),) = initial.get("solve", {"": ""}).items()
        is_momentum = [f"p_{name}" in initial or solved == f"p_{name}" for name in names]
        given = [number(initial.get(f"p_{name}", initial.get(f"{name}_dot", 0))) for name in names]
        unknown = [a for a in range(n) if is_momentum[a]]

        def velocities(given, one_form):
            rows = [[matrix[a][b] for b in unknown] for a in unknown]
            known = [b for b in range(n) if not is_momentum[b]]
            rhs = [given[a] - one_form[a] - sum(matrix[a][b] * given[b] for b in known) for a in unknown]
            result = list(given)
            for a, value in zip(unknown, solve_dense(rows, rhs)):
                result[a] = value
            return result

        q_dot = velocities(given, one_form)
        form = lambda u, v: sum(u[a] * matrix[a][b] * v[b] for a in range(n) for b in range(n))
        if solved:
            direction = [mpf(solved in (f"p_{name}", f"{name}_dot")) for name in names]
            beta = velocities(direction, [mpf(0)] * n)
            norm = number({"timelike": 1, "null": 0}.get(initial["norm"], initial["norm"]))
            square, middle, rest = form(beta, beta), form(q_dot, beta), form(q_dot, q_dot) - norm
            if square == 0:
                root = -rest / (2 * middle)
            else:
                root = mp.sqrt(middle**2 - square * rest)
                roots = sorted([(-middle - root) / square, (-middle + root) / square])
                root = roots[1 if sign == "+" else 0]
            q_dot = [u + root * v for u, v in zip(q_dot, beta)]
        p = [sum(g * u for g, u in zip(row, q_dot)) + v for row, v in zip(matrix, one_form)]
        return q, p, form(q_dot, q_dot)

    def position(self, y):
        return dict(zip(self.coordinates, y))

    def velocity(self, y):
        return {f"{name}_dot": u for name, u in zip(self.coordinates, self.rates(y))}


class Newtonian:
    """A scene with Newton's law. Its state is t, x, s, then v; the parameter is t, or gamma where t_dot is 1."""

    def __init__(self, case):
        table, particle, initial = case["potential"], case.get("particle", {}), case["initial"]
        names = table.get("coordinates", ["x"])
        self.names, self.coordinates = names, ["t", *names, "s"]
        self.formulas = Formulas(table.get("parameters", {}), {}, names)
        number = self.formulas.number
        self.potential = self.formulas.formula(table["formula"])
        self.forces = {names.index(a): self.formulas.formula(text) for a, text in table.get("force", {}).items()}
        masses = particle.get("masses", {name: particle.get("mass", 1) for name in names})
        self.masses = [number(masses[name]) for name in names]
        self.one_form = {names.index(a): self.formulas.formula(text) for a, text in table.get("one_form", {}).items()}
        if number(initial.get("t_dot", 1)) != 1:
            raise ValueError("only with t_dot = 1")
        if self.one_form and any(f"p_{name}" in initial for name in names):
            raise ValueError("with a one-form only from velocities")
        if "conformal" in table and "t_f" not in case["grid"]:
            raise ValueError("conformal needs an end in t")
        self.gamma_i = number(case["grid"].get("gamma_i", 0))
        position = [number(initial.get(name, 0)) for name in self.coordinates]
        velocity = [
            number(initial[f"{name}_dot"]) if f"{name}_dot" in initial else -number(initial[f"p_{name}"]) / mass
            for name, mass in zip(names, self.masses)
        ]
        self.state = position + velocity

    def rates(self, y):
        n = len(self.names)
        x, v = y[1 : n + 1], y[n + 2 :]
        names = self.formulas.names(x)
        acceleration = []
        # The derivatives of A_b by q^a, where there is a one-form.
        by = [[mpf(0)] * n for _ in range(n)]
        for a in range(n):
            shifted = [mpc(u, COMPLEX_STEP) if b == a else u for b, u in enumerate(x)]
            for b, formula in self.one_form.items():
                by[a][b] = mp.im(formula(self.formulas.names(shifted))) / COMPLEX_STEP
        for a in range(n):
            shifted = [mpc(u, COMPLEX_STEP) if b == a else u for b, u in enumerate(x)]
            force = -mp.im(self.potential(self.formulas.names(shifted))) / COMPLEX_STEP
            force += sum((by[a][b] - by[b][a]) * v[b] for b in range(n))
            if a in self.forces:
                force += self.forces[a](names | {f"{name}_dot_": u for name, u in zip(self.names, v)})
            acceleration.append(force / self.masses[a])
        kinetic = sum(m * u * u for m, u in zip(self.masses, v)) / 2
        work = sum(formula(names) * v[b] for b, formula in self.one_form.items())
        return [mpf(1), *v, kinetic - self.potential(names) + work, *acceleration]

    def position(self, y):
        return dict(zip(self.coordinates, y))

    def velocity(self, y):
        return {f"{name}_dot": u for name, u in zip(self.coordinates, self.rates(y))}


def extrapolated_step(rates, y, length):
    """A step of the extrapolated midpoint rule, and how much its last extrapolation changed."""
    slope, table = rates(y), []
    for j in range(1, COLUMNS + 1):
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


def integrate(scene, length, until):
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


def collocate(scene, sbp, n, h, form):
    """The last node of the collocation system (D y)_k = rates(y_k) over one window; of the weak form with D-bar."""
    d, penalty = derivative_rows(sbp, n, h, form)
    y, m = [scene.state], len(scene.state)
    with mp.workdps(15):
        for _ in range(n - 1):  # Runge and Kutta, for a first guess
            y.append(y[-1])
            for _ in range(4):
                s, u = h / 4, y[-1]
                k1 = scene.rates(u)
                k2 = scene.rates([a + s / 2 * b for a, b in zip(u, k1)])
                k3 = scene.rates([a + s / 2 * b for a, b in zip(u, k2)])
                k4 = scene.rates([a + s * b for a, b in zip(u, k3)])
                y[-1] = [a + s / 6 * (b + 2 * c + 2 * e + f) for a, b, c, e, f in zip(u, k1, k2, k3, k4)]
    first = 0 if form == "weak" else 1
    step = mpf("1e-45")
    for _ in range(20):
        jacobian, residual = [], []
        for k, row in enumerate(d):
            rates = scene.rates(y[k])
            slopes = []
            for b in range(m):
                moved = [u + step if a == b else u for a, u in enumerate(y[k])]
                slopes.append([(u - v) / step for u, v in zip(scene.rates(moved), rates)])
            for a in range(m):
                entries = {m * (j - first) + a: weight for j, weight in row.items() if j >= first}
                if k >= first:
                    for b in range(m):
                        if slopes[b][a]:
                            column = m * (k - first) + b
                            entries[column] = entries.get(column, 0) - slopes[b][a]
                jacobian.append(entries)
                own = sum(weight * y[j][a] for j, weight in row.items()) - rates[a]
                residual.append(own - penalty * scene.state[a] if form == "weak" and k == 0 else own)
        change = solve_banded(jacobian, residual)
        for j in range(first, n):
            for a in range(m):
                y[j][a] -= change[m * (j - first) + a]
        if max(map(abs, change)) < mpf("1e-60"):
            return y[-1]
    raise ArithmeticError("Newton's method did not converge")


def solve(case):
    """The coordinates at the end, and gamma there."""
    is_newtonian = case.get("particle", {}).get("law") == "newtonian"
    # With an accuracy the program takes spectral elements.
    grid, scheme = case["grid"], case.get("scheme", {"sbp": "GLL"})
    is_spectral = scheme["sbp"].startswith("GLL")
    mp.dps = DIGITS if is_spectral else COLLOCATION_DIGITS
    scene = Newtonian(case) if is_newtonian else Hamiltonian(case)
    number = scene.formulas.number
    if not is_spectral:
        if is_newtonian or "t_f" in grid or "until" in grid or grid.get("windows", 1) != 1:
            raise ValueError("an SBP operator only in one window up to gamma_f, and not with Newton's law")
        length, n = number(grid.get("gamma_f", 1)) - scene.gamma_i, grid["n_gamma"]
        y = collocate(scene, scheme["sbp"], n, length / (n - 1), scheme.get("form", "strong"))
        return scene.position(y), scene.gamma_i + length
    until, length = None, mpf("1e18")
    if "t_f" in grid:
        t, t_f = scene.coordinates.index("t"), number(grid["t_f"])
        if is_newtonian:
            length = t_f - scene.state[0]  # the parameter is t
        else:
            until = lambda y: y[t] - t_f
    else:
        length = number(grid.get("gamma_f", 1)) - scene.gamma_i
    if "until" in grid:
        formula = Formula(grid["until"]).compiled()
        names = lambda y: {f"{name}_": u for name, u in (scene.position(y) | scene.velocity(y)).items()}
        until = lambda y: formula(scene.formulas.parameters | names(y))
    y, gone = integrate(scene, length, until)
    return scene.position(y), scene.gamma_i + gone


def check(path, write):
    """Prints the lines of one scene; true if nothing differs."""
    text = path.read_text(encoding="utf-8")
    head, _, tail = re.split(r"(?m)^(\[expect\].*)$", text) if "\n[expect]" in text else (text, "", "")
    case, expect = load(head), load(tail)
    position, gamma = solve(case)
    expected = lambda name: Formula(expect[name]).compiled()({})
    chosen = [name for name in position if f"{name}_final" in expect] or [name for name in position if name != "s"]
    found = {f"{name}_final": position[name] for name in chosen}
    if "gamma_final" in expect:
        found["gamma_final"] = gamma
    differences = [abs(value - expected(name)) for name, value in found.items() if name in expect]
    tolerance = mpf(expect.get("tolerance", WRITTEN_TOLERANCE))
    ok = all(difference <= tolerance for difference in differences)
    verdict = f"difference {mp.nstr(max(differences), 2)} {'ok' if ok else 'DIFFERS'}" if differences else "no [expect]"
    numbers = ", ".join(f"{name} = {mp.nstr(value, 22)}" for name, value in position.items())
    print(f"{path.stem:22} {verdict}\n    {numbers}, gamma = {mp.nstr(gamma, 22)}", flush=True)
    if write:
        lines = "".join(f"{name} = {mp.nstr(value, 17)}\n" for name, value in found.items())
        lines += f"tolerance = {expect.get('tolerance', WRITTEN_TOLERANCE)}\n"
        header = text[len(head) : len(text) - len(tail)] or "\n[expect]"
        path.write_text(f"{head}{header}\n{lines}", encoding="utf-8")
    return ok or write


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the numbers into the [expect] tables")
    parser.add_argument("cases", metavar="CASE", nargs="*", type=Path, help="case files (default: all scenes)")
    arguments = parser.parse_args()
    folder = Path(__file__).resolve().parent.parent / "cases" / "scenes"
    cases = arguments.cases or sorted(folder.glob("*.toml"))
    results = [check(path, arguments.write) for path in cases]
    sys.exit(0 if all(results) else 1)


if __name__ == "__main__":
    main()
