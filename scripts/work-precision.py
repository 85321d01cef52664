#!/usr/bin/env python3
# /// script
# requires-python = ">=3.11"
# dependencies = ["heyoka>=7", "mpmath", "numpy", "scipy>=1.13"]
# ///
"""`geodesic-ivp work-precision` with rows from Python beside it: heyoka's Taylor method and SciPy's solve_ivp.

    uv run scripts/work-precision.py CASE [--gamma-f L,L] [--out DIR] [--longest SECONDS] [--program PATH]

Measures these methods on the case's world-line, then has the program measure its own in the same minute, rank all
together (`--rows`) and draw them. Everything else works without Python.

The same rules: t, x and w at ten equally spaced values of γ; errors against a run of the program in 32 digits (GLL24 in
short windows); minimum and median of repeated runs, in turns. What heyoka compiles is compiled beforehand, and its
integrator is reused: only the integration is timed. Its steps are controlled by the largest component of the
state, to which t would belong and grow: on runs longer than 20 t starts from 0 in each tenth of the run and is summed.
SciPy gets an absolute tolerance for t that takes it out of the error norm, and right-hand sides in plain Python.

Of a scene heyoka integrates Hamilton's equations of the active coordinates, with the charges as constants, and the
ignorable coordinates as quadratures like t. The Hamiltonian is ½ g^ab (p_a − A_a)(p_b − A_b) with a one-form A, or T + V
with Newton's law. Scenes with a force or a conformal factor are not understood. """

import argparse
import ast
import csv
import json
import math
import operator
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from decimal import Decimal, getcontext
from pathlib import Path

import heyoka as hy
import numpy as np
from scene_expectations import DEFAULTS, PRESETS
from scipy.integrate import solve_ivp

getcontext().prec = 50
OUTPUTS = 10
LONGEST = 0.5  # seconds of a run; the next tolerance of its method is not tried
ROUNDS = 15
ANY = 1e10  # an absolute tolerance that takes t out of the norm
BEHIND = "delta_k_max seconds_min seconds_median evaluations points status gamma_f".split()


def power(base, exponent):
    """The series of a general power divides by its base, which may be 0: small powers are products."""
    if isinstance(base, hy.expression) and exponent in (2.0, 3.0, 4.0, 5.0, 6.0):
        half = power(base, exponent // 2) if exponent > 3.0 else base
        return half * half * base if exponent % 2 else half * half
    return operator.pow(base, exponent)


OPERATIONS = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.Pow: power, ast.USub: operator.neg, ast.UAdd: operator.pos},
}
FUNCTIONS = "sin cos tan sinh cosh tanh asin acos atan exp sqrt".split()


def evaluate(text, names, functions):
    """The expression of a case file with the values of its names; the grammar is Python's with ^ in place of **."""
    python = re.sub(r"(?<![\w.])[A-Za-z_]\w*", r"\g<0>_", text).replace("^", "**")

    def walk(node):
        match node:
            case ast.Constant(value=value):
                return float(value)
            case ast.Name(id=name):
                return names[name[:-1]]
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                return functions[name[:-1]](walk(argument))
            case ast.UnaryOp(op=op, operand=u):
                return OPERATIONS[type(op)](walk(u))
            case ast.BinOp(left=u, op=op, right=v):
                return OPERATIONS[type(op)](walk(u), walk(v))
        raise ValueError(f"not understood: {text}")

    return walk(ast.parse(f"({python})", mode="eval").body)


def potential(spec, x):
    """V as an expression of heyoka."""
    ((kind, values),) = spec.items()
    if kind == "formula":
        values = {"expression": values} if isinstance(values, str) else values
        functions = {name: getattr(hy, name) for name in FUNCTIONS} | {"ln": hy.log}
        names = {name: float(value) for name, value in values.get("parameters", {}).items()}
        return evaluate(values["expression"], names | {"x": x, "pi": math.pi}, functions)
    coefficients = {"free": [], "linear": [0.0, values.get("alpha")], "quartic": [0.0] * 4 + [values.get("kappa")]}
    coefficients = coefficients.get(kind, values.get("coefficients"))
    return sum((float(c) * x**k for k, c in enumerate(coefficients) if c), hy.expression(0.0))


class World:
    """The first-order system of a case of one coordinate, with t outside. A state is x, w, t."""

    coordinates = ["t", "x"]

    def __init__(self, case):
        particle, initial = case.get("particle", {}), case["initial"]
        self.x = hy.make_vars("x")
        self.w = hy.make_vars("w")
        self.t = hy.make_vars("t")
        self.g00 = float(particle.get("c", 1.0)) ** 2 + 2.0 / float(particle.get("mass", 1.0)) * potential(
            case["potential"], self.x
        )
        functions = hy.cfunc([self.g00, hy.diff(self.g00, self.x)], [self.x])
        self.metric = lambda x: functions([x])
        t_dot = float(initial["t_dot"])
        self.start = [float(initial["x"]), float(initial.get("x_dot", t_dot * float(initial.get("velocity", 0.0))))]
        g = self.metric(self.start[0])[0]
        self.q = g * t_dot
        self.k = g * t_dot**2 - self.start[1] ** 2
        u = self.q / self.g00
        self.u = u
        self.a = -0.5 * hy.diff(self.g00, self.x) * u**2
        # Right-hand sides for SciPy in plain Python.
        text = {name: str(e) for name, e in (("u", u), ("a", self.a))}
        names = {name: getattr(math, name) for name in FUNCTIONS} | {"log": math.log}
        self.rates = eval(f"lambda x: ({text['u']}, {text['a']})", names)  # heyoka prints Python
        self.system = [(self.x, self.w), (self.w, self.a), (self.t, self.u)]
        self.origin = [Decimal(str(initial.get("t", 0))), Decimal(0)]

    def place(self, state):
        """The coordinates, from their origin."""
        x, _, t = state
        return [t, x]

    def delta_k(self, state):
        x, w, _ = state
        return self.q**2 / self.metric(x)[0] - w**2 - self.k


class Scene:
    """Hamilton's equations of a scene. A state is q and p of the active coordinates, and then the ignorable ones."""

    def __init__(self, case):
        initial = case["initial"]
        self.numbers = {"pi": math.pi}
        table = case.get("metric") or case["potential"]
        unknown = {"force", "conformal"} if "metric" in case else {"one_form", "force", "conformal"}
        if unknown := unknown & table.keys():
            sys.exit(f"not understood in a scene: {', '.join(sorted(unknown))}")
        self.functions = {name: getattr(hy, name) for name in FUNCTIONS} | {"ln": hy.log}
        parameters = DEFAULTS.get(table.get("preset"), {}) | table.get("parameters", {})
        for name, value in parameters.items():
            self.numbers[name] = self.number(value)
        hamiltonian, rates, momenta = (self.of_metric if "metric" in case else self.of_potential)(case, table)
        self.origin = [Decimal(repr(self.number(initial.get(name, 0)))) for name in self.coordinates]
        depends = {str(name) for name in hy.get_variables(hamiltonian)}
        self.active = [a for a, name in enumerate(self.coordinates) if name in depends]
        self.ignorable = [a for a in range(len(self.coordinates)) if a not in self.active]
        self.origin = [Decimal(0) if a in self.active else origin for a, origin in enumerate(self.origin)]
        q, p = [hy.make_vars(name) for name in self.coordinates], self.p
        constants = {p[a]: hy.expression(momenta[a]) for a in self.ignorable}
        fixed = lambda expression: hy.subs(expression, constants)
        self.system = [(q[a], fixed(rates[a])) for a in self.active]
        self.system += [(p[a], fixed(-hy.diff(hamiltonian, q[a]))) for a in self.active]
        self.system += [(q[a], fixed(rates[a])) for a in self.ignorable]
        self.start = [self.number(initial[self.coordinates[a]]) for a in self.active]
        self.start += [momenta[a] for a in self.active]
        variables = [q[a] for a in self.active] + [p[a] for a in self.active]
        twice = hy.cfunc([2.0 * fixed(hamiltonian)], variables)
        # K = 2 H of a metric. In the lift of Newton's law with p_s = 1 it is -2 times what the energy is off by.
        self.k_of = lambda state: twice(np.array(state[: len(variables)]))[0]
        self.k = self.k_of(self.start)

    def number(self, value):
        functions = {name: getattr(math, name) for name in FUNCTIONS}
        return float(value) if not isinstance(value, str) else evaluate(value, self.numbers, functions)

    def expression(self, text, names):
        return hy.expression(0.0) + evaluate(str(text), self.numbers | names, self.functions)

    def of_metric(self, case, table):
        """H, dq^a/dγ of all coordinates, and their momenta at the start."""
        coordinates, definitions, components = PRESETS.get(table.get("preset"), (None, {}, {}))
        self.coordinates = table.get("coordinates", coordinates)
        definitions, components = definitions | table.get("definitions", {}), components | table.get("components", {})
        names = {name: hy.make_vars(name) for name in self.coordinates}
        while waiting := {name: text for name, text in definitions.items() if name not in names}:
            for name, text in waiting.items():
                if not set(re.findall(r"[A-Za-z_]\w*", text)) & waiting.keys():
                    names[name] = self.expression(text, names)
        n = len(self.coordinates)
        metric = {}
        for pair, text in components.items():
            a, b = sorted(self.coordinates.index(name) for name in pair.split())
            metric[a, b] = self.expression(text, names)
        g = lambda a, b: metric.get((min(a, b), max(a, b)), hy.expression(0.0))
        inverse, paired = {}, {pair for pair in metric if pair[0] != pair[1]}
        if len({a for pair in paired for a in pair}) != 2 * len(paired):
            sys.exit("more than two coordinates are coupled")
        for a in range(n):
            if not any(a in pair for pair in paired):
                inverse[a, a] = 1.0 / metric[a, a]
        for a, b in paired:
            determinant = g(a, a) * g(b, b) - g(a, b) ** 2
            inverse[a, a], inverse[b, b] = g(b, b) / determinant, g(a, a) / determinant
            inverse[a, b] = -g(a, b) / determinant
        self.p = [hy.make_vars(f"p_{name}") for name in self.coordinates]
        one_form = [self.expression(table.get("one_form", {}).get(name, 0), names) for name in self.coordinates]
        kinetic = [p - form for p, form in zip(self.p, one_form)]
        terms = [g * kinetic[a] * kinetic[b] * (0.5 if a == b else 1.0) for (a, b), g in inverse.items()]
        hamiltonian = sum(terms[1:], terms[0])
        place = [self.number(case["initial"].get(name, 0)) for name in self.coordinates]
        q = [hy.make_vars(name) for name in self.coordinates]
        at_start = lambda expression: hy.cfunc([expression], q)(np.array(place))[0]
        entries = np.array([[at_start(g(a, b)) for b in range(n)] for a in range(n)])
        initial = self.with_norm(case["initial"], entries)
        momenta = []
        for a, name in enumerate(self.coordinates):
            if (given := initial.get(f"p_{name}")) is not None:
                momenta.append(self.number(given))
            else:
                dots = [self.number(initial.get(f"{other}_dot", 0)) for other in self.coordinates]
                momenta.append(entries[a] @ dots + at_start(one_form[a]))
        return hamiltonian, [hy.diff(hamiltonian, p) for p in self.p], momenta

    def with_norm(self, initial, entries):
        """The initial data with the rate that follows from K."""
        missing = [name for name in self.coordinates if not {f"{name}_dot", f"p_{name}"} & initial.keys()]
        if not missing:
            return initial
        if len(missing) > 1 or any(f"p_{name}" in initial for name in self.coordinates) or "norm" not in initial:
            sys.exit("not understood in a scene: norm and solve beside momenta")
        a, norm = self.coordinates.index(missing[0]), {"timelike": 1.0, "null": 0.0}.get(initial["norm"])
        given = (initial.get(f"{name}_dot", 0) for name in self.coordinates)
        dots = np.array([self.number(value) for value in given])
        half, rest = entries[a] @ dots, dots @ entries @ dots - (self.number(initial["norm"]) if norm is None else norm)
        root = math.sqrt(half**2 - entries[a, a] * rest)
        roots = sorted((-half + sign * root) / entries[a, a] for sign in (-1.0, 1.0))
        return initial | {f"{missing[0]}_dot": roots["-+".index(initial["solve"][f"{missing[0]}_dot"])]}

    def of_potential(self, case, table):
        """The same of Newton's law with masses 1, where t is γ and s the action."""
        particle = case.get("particle", {})
        if particle.get("law") != "newtonian" or particle.keys() - {"law"}:
            sys.exit("not understood in a scene: a potential without Newton's law, or with masses")
        names = table.get("coordinates", ["x"])
        self.coordinates = ["t", *names, "s"]
        formula = table["formula"]
        formula = formula["expression"] if isinstance(formula, dict) else formula
        potential = self.expression(formula, {name: hy.make_vars(name) for name in names})
        self.p = [hy.make_vars(f"p_{name}") for name in self.coordinates]
        kinetic = sum((0.5 * p**2 for p in self.p[1:-1]), hy.expression(0.0))
        momenta = [0.0, *(self.number(case["initial"][f"{name}_dot"]) for name in names), 0.0]
        rates = [hy.expression(1.0), *self.p[1:-1], kinetic - potential]
        return kinetic + potential, rates, momenta

    def place(self, state):
        """The coordinates; ignorable ones from the start."""
        q = dict(zip(self.active, state))
        q |= dict(zip(self.ignorable, state[2 * len(self.active) :]))
        return [q[a] for a in range(len(self.coordinates))]

    def delta_k(self, state):
        return self.k_of(state) - self.k


def heyoka(world, length, tolerance):
    moving, count = len(world.start), len(world.system)
    initial = np.array([*world.start, *[0.0] * (count - moving)])
    integrator = hy.taylor_adaptive(world.system, initial, tol=tolerance)
    grid = np.linspace(0.0, length, OUTPUTS + 1)
    sliced = length > 20.0

    def run():
        integrator.time = 0.0
        integrator.state[:] = initial
        if not sliced:
            # (outcome, shortest step, longest step, steps, callback, states)
            outcome = integrator.propagate_grid(grid)
            return outcome[5][1:], outcome[3]
        states, steps, elapsed = np.empty((OUTPUTS, count)), 0, np.zeros(count - moving)
        for k in range(OUTPUTS):
            integrator.state[moving:] = 0.0
            steps += integrator.propagate_until(grid[k + 1])[3]
            elapsed += integrator.state[moving:]
            states[k, :moving], states[k, moving:] = integrator.state[:moving], elapsed
        return states, steps

    return run, lambda steps: steps * integrator.order


def scipy(method):
    def make(world, length, tolerance):
        rates, calls = world.rates, [0]

        def f(_, y):
            calls[0] += 1
            u, a = rates(y[0])
            return y[1], a, u

        def run():
            calls[0] = 0
            grid, y, steps = np.linspace(0.0, length, OUTPUTS + 1), [*world.start, 0.0], 0
            arguments = dict(method=method, rtol=max(tolerance, 3e-14), atol=[tolerance, tolerance, ANY])
            if method != "Radau":
                solution = solve_ivp(f, (0.0, length), y, t_eval=grid[1:], **arguments)
                return solution.y.T, calls[0] // 12
            # Its dense output is of order 3 only.
            states = []
            for a, b in zip(grid, grid[1:]):
                solution = solve_ivp(f, (a, b), y, **arguments)
                y, steps = solution.y[:, -1], steps + solution.t.size - 1
                states.append(y)
            return np.array(states), steps

        return run, lambda _: calls[0]

    return make


HEYOKA = {"heyoka": heyoka}
METHODS = HEYOKA | {f"SciPy {method}": scipy(method) for method in ("DOP853", "LSODA", "Radau")}


def reference(program, case, world, length):
    """γ_f and the coordinates at the points of output, in 32 digits."""
    scheme = ["--set", 'scheme={sbp="GLL24",form="weak"}']
    run = [program, "run", str(case), "--quiet", *scheme]
    with tempfile.TemporaryDirectory() as folder:
        grid = tomllib.loads(Path(case).read_text(encoding="utf-8"))["grid"]
        if isinstance(world, Scene):
            own = world.number(grid["gamma_f"]) - world.number(grid.get("gamma_i", 0))
            length = own if length is None else length
            # Windows half as long as those that are good to 1e-12.
            windows = OUTPUTS * math.ceil(2 * grid["windows"] * length / own / OUTPUTS)
        elif length is None:
            end = f"t_f={grid['t_f']}" if "t_f" in grid else f"gamma_f={grid.get('gamma_f', 1.0)}"
            start = grid.get("gamma_i", 0.0) if "t_f" not in grid else 0.0
            subprocess.run([*run, "--set", f"grid={{{end},gamma_i={start},windows=200}}", "--out", folder], check=True)
            length = json.loads((Path(folder) / "summary.json").read_text())["gamma_final"] - start
        if isinstance(world, World):
            windows = OUTPUTS * math.ceil(max(40, 4 * length) / OUTPUTS)
        step = Decimal(repr(length)) / OUTPUTS
        options = ["--set", f"grid={{gamma_f={length!r},windows={windows}}}", "--set", "solver.digits=32"]
        subprocess.run([*run, *options, "--sample-gamma", f"0:{length!r}:{step:f}", "--out", folder], check=True)
        with open(Path(folder) / "samples.csv", newline="") as file:
            rows = [[Decimal(row[name]) for name in world.coordinates] for row in csv.DictReader(file)][1:]
    return length, rows


def attempt(world, exact, run):
    """Errors of the coordinates and of K."""
    states, steps = run()
    if len(states) < OUTPUTS or not np.isfinite(states).all():
        return None, steps
    errors = [0.0] * (len(world.coordinates) + 1)
    for state, wanted in zip(states, exact):
        place = zip(world.place(state), world.origin, wanted)
        found = [abs(Decimal(float(q)) + origin - want) for q, origin, want in place]
        found.append(abs(world.delta_k(state)))
        errors = [max(a, float(b)) for a, b in zip(errors, found)]
    return errors, steps


def measure(world, exact, length):
    jobs = []
    sizes = [max(float(abs(row[a] - origin)) for row in exact) for a, origin in enumerate(world.origin)]
    for name, make in (METHODS if isinstance(world, World) else HEYOKA).items():
        for digits in range(3, 16):
            run, count = make(world, length, 10.0**-digits)
            start = time.perf_counter()
            errors, steps = attempt(world, exact, run)
            seconds = time.perf_counter() - start
            status = "converged"
            if errors is None:
                status = "failed"
            elif any(error > 0.1 * size for error, size in zip(errors, sizes)):
                status = "inaccurate"
            errors = errors or [""] * (len(sizes) + 1)
            times = dict(seconds_min=seconds, seconds_median=seconds, evaluations=count(steps), points=steps)
            row = dict(zip(columns(world), [name, f"tol=1e-{digits}", *errors])) | times
            row |= dict(status=status, gamma_f=length)
            jobs.append((row, run, []))
            print(f"{name:14} tol=1e-{digits:<3} {status:10} {seconds:.2e} s", file=sys.stderr)
            if seconds > LONGEST:
                break
    for round in range(ROUNDS):
        for row, run, samples in jobs:
            if row["status"] != "converged" or (round >= 3 and row["seconds_min"] > 0.01):
                continue
            repetitions = min(1000, math.ceil(5e-5 / (samples[0] if samples else row["seconds_min"])))
            start = time.perf_counter()
            for _ in range(repetitions):
                run()
            samples.append((time.perf_counter() - start) / repetitions)
    for row, _, samples in jobs:
        if samples:
            row["seconds_min"], row["seconds_median"] = min(samples), sorted(samples)[len(samples) // 2]
    return [row for row, _, _ in jobs]


def columns(world):
    return ["method", "setting", *(f"error_{name}" for name in world.coordinates), *BEHIND]


def is_scene(case):
    """Whether a case is one of several coordinates, of another metric or of another law."""
    potential, particle = case.get("potential", {}), case.get("particle", {})
    several = {"coordinates", "one_form", "force", "conformal"}
    return "metric" in case or bool(several & potential.keys()) or bool({"masses", "law"} & particle.keys())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", metavar="CASE", type=Path)
    parser.add_argument("--gamma-f", metavar="L,L", help="lengths in gamma (default: the case's own)")
    parser.add_argument("--out", metavar="DIR", type=Path, help="default: results/<case file stem>/work-precision")
    parser.add_argument("--longest", metavar="SECONDS", help="that a run of the program may take (default: its own)")
    parser.add_argument("--program", help="the geodesic-ivp to run (default: target/release/, or on the PATH)")
    arguments = parser.parse_args()
    built = Path(__file__).resolve().parent.parent / "target/release/geodesic-ivp"
    program = arguments.program or (str(built) if built.exists() else shutil.which("geodesic-ivp"))
    if not program:
        sys.exit("geodesic-ivp is not on the PATH: build it with cargo build --release")
    out = arguments.out or Path("results") / arguments.case.stem / "work-precision"
    case = tomllib.loads(arguments.case.read_text(encoding="utf-8"))
    world = Scene(case) if is_scene(case) else World(case)
    lengths = [float(length) for length in arguments.gamma_f.split(",")] if arguments.gamma_f else [None]
    rows = []
    for length in lengths:
        length, exact = reference(program, arguments.case, world, length)
        rows += measure(world, exact, length)
    out.mkdir(parents=True, exist_ok=True)
    table = out / "work_precision_python.csv"
    with open(table, "w", newline="") as file:
        writer = csv.DictWriter(file, columns(world))
        writer.writeheader()
        writer.writerows(rows)
    command = [program, "work-precision", str(arguments.case), "--plot", "--rows", str(table), "--out", str(out)]
    if arguments.gamma_f:
        command += ["--gamma-f", arguments.gamma_f]
    if arguments.longest:
        command += ["--longest", arguments.longest]
    sys.exit(subprocess.run(command).returncode)


if __name__ == "__main__":
    main()
