#!/usr/bin/env python3
# /// script
# requires-python = ">=3.11"
# dependencies = ["heyoka>=7", "numpy", "scipy>=1.13"]
# ///
"""`geodesic-ivp work-precision` with rows from Python beside it: heyoka's Taylor method and SciPy's solve_ivp.

    uv run scripts/work-precision.py CASE [--gamma-f L,L] [--out DIR] [--program PATH]

Measures these methods on the case's world-line, then has the program measure its own in the same minute, rank all together
(`--rows`) and draw them. Everything else works without Python.

The same rules: t, x and w at ten equally spaced values of γ; errors against a run of the program in 32 digits (GLL24 in
short windows); minimum and median of repeated runs, in turns. What heyoka compiles is compiled beforehand, and its
integrator is reused: only the integration is timed. Its steps are controlled by the largest component of the
state, to which t would belong and grow: on runs longer than 20 t starts from 0 in each tenth of the run and is summed.
SciPy gets an absolute tolerance for t that takes it out of the error norm, and right-hand sides in plain Python.
"""

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
from scipy.integrate import solve_ivp

getcontext().prec = 50
OUTPUTS = 10
LONGEST = 0.5  # seconds of a run; the next tolerance of its method is not tried
ROUNDS = 15
ANY = 1e10  # an absolute tolerance that takes t out of the norm
COLUMNS = "method setting error_t error_x delta_k_max seconds_min seconds_median evaluations points status gamma_f"

OPERATIONS = {
    **{ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv},
    **{ast.Pow: operator.pow, ast.USub: operator.neg, ast.UAdd: operator.pos},
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
    """The first-order system of a case, with t outside."""

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

    def taylor(self, tolerance):
        system = [(self.x, self.w), (self.w, self.a), (self.t, self.u)]
        return hy.taylor_adaptive(system, [*self.start, 0.0], tol=tolerance)


def heyoka(world, length, tolerance):
    integrator = world.taylor(tolerance)
    initial = np.array([*world.start, 0.0])
    grid = np.linspace(0.0, length, OUTPUTS + 1)
    sliced = length > 20.0

    def run():
        integrator.time = 0.0
        integrator.state[:] = initial
        if not sliced:
            # (outcome, shortest step, longest step, steps, callback, states)
            outcome = integrator.propagate_grid(grid)
            return outcome[5][1:], outcome[3]
        states, steps, elapsed = np.empty((OUTPUTS, 3)), 0, 0.0
        for k in range(OUTPUTS):
            integrator.state[2] = 0.0
            steps += integrator.propagate_until(grid[k + 1])[3]
            elapsed += integrator.state[2]
            states[k] = integrator.state[0], integrator.state[1], elapsed
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


METHODS = {"heyoka": heyoka, **{f"SciPy {method}": scipy(method) for method in ("DOP853", "LSODA", "Radau")}}


def reference(program, case, length):
    """γ_f and (t − t_i, x) at the points of output, in 32 digits."""
    scheme = ["--set", 'scheme={sbp="GLL24",form="weak"}']
    run = [program, "run", str(case), "--quiet", *scheme]
    with tempfile.TemporaryDirectory() as folder:
        if length is None:
            grid = tomllib.loads(Path(case).read_text(encoding="utf-8"))["grid"]
            end = f"t_f={grid['t_f']}" if "t_f" in grid else f"gamma_f={grid.get('gamma_f', 1.0)}"
            start = grid.get("gamma_i", 0.0) if "t_f" not in grid else 0.0
            subprocess.run([*run, "--set", f"grid={{{end},gamma_i={start},windows=200}}", "--out", folder], check=True)
            length = json.loads((Path(folder) / "summary.json").read_text())["gamma_final"] - start
        windows = OUTPUTS * math.ceil(max(40, 4 * length) / OUTPUTS)
        step = Decimal(repr(length)) / OUTPUTS
        options = ["--set", f"grid={{gamma_f={length!r},windows={windows}}}", "--set", "solver.digits=32"]
        subprocess.run([*run, *options, "--sample-gamma", f"0:{length!r}:{step:f}", "--out", folder], check=True)
        with open(Path(folder) / "samples.csv", newline="") as file:
            rows = [(Decimal(row["t"]), Decimal(row["x"])) for row in csv.DictReader(file)][1:]
    return length, rows


def attempt(world, exact, t_i, run):
    """Errors of t, x and K."""
    states, steps = run()
    if len(states) < OUTPUTS or not np.isfinite(states).all():
        return None, steps
    errors = [0.0, 0.0, 0.0]
    for (x, w, t), (t_exact, x_exact) in zip(states, exact):
        k = world.q**2 / world.metric(x)[0] - w**2
        found = abs(Decimal(float(t)) + t_i - t_exact), abs(Decimal(float(x)) - x_exact), abs(k - world.k)
        errors = [max(a, float(b)) for a, b in zip(errors, found)]
    return errors, steps


def measure(world, exact, t_i, length):
    jobs, sizes = [], (float(exact[-1][0] - t_i), max(abs(float(x)) for _, x in exact))
    for name, make in METHODS.items():
        for digits in range(3, 16):
            run, count = make(world, length, 10.0**-digits)
            start = time.perf_counter()
            errors, steps = attempt(world, exact, t_i, run)
            seconds = time.perf_counter() - start
            status = "converged"
            if errors is None:
                status = "failed"
            elif errors[0] > 0.1 * sizes[0] or errors[1] > 0.1 * sizes[1]:
                status = "inaccurate"
            row = [name, f"tol=1e-{digits}", *(errors or ["", "", ""]), seconds, seconds, count(steps), steps, status, length]
            jobs.append((row, run, []))
            print(f"{name:14} tol=1e-{digits:<3} {status:10} {seconds:.2e} s", file=sys.stderr)
            if seconds > LONGEST:
                break
    for round in range(ROUNDS):
        for row, run, samples in jobs:
            if row[9] != "converged" or (round >= 3 and row[5] > 0.01):
                continue
            repetitions = min(1000, math.ceil(5e-5 / (samples[0] if samples else row[5])))
            start = time.perf_counter()
            for _ in range(repetitions):
                run()
            samples.append((time.perf_counter() - start) / repetitions)
    for row, _, samples in jobs:
        if samples:
            row[5], row[6] = min(samples), sorted(samples)[len(samples) // 2]
    return [row for row, _, _ in jobs]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", metavar="CASE", type=Path)
    parser.add_argument("--gamma-f", metavar="L,L", help="lengths in gamma (default: the case's own)")
    parser.add_argument("--out", metavar="DIR", type=Path, help="default: results/<case file stem>/work-precision")
    parser.add_argument("--program", help="the geodesic-ivp to run (default: target/release/, or on the PATH)")
    arguments = parser.parse_args()
    built = Path(__file__).resolve().parent.parent / "target/release/geodesic-ivp"
    program = arguments.program or (str(built) if built.exists() else shutil.which("geodesic-ivp"))
    if not program:
        sys.exit("geodesic-ivp is not on the PATH: build it with cargo build --release")
    out = arguments.out or Path("results") / arguments.case.stem / "work-precision"
    case = tomllib.loads(arguments.case.read_text(encoding="utf-8"))
    world, t_i = World(case), Decimal(str(case["initial"].get("t", 0)))
    lengths = [float(length) for length in arguments.gamma_f.split(",")] if arguments.gamma_f else [None]
    rows = []
    for length in lengths:
        length, exact = reference(program, arguments.case, length)
        rows += measure(world, exact, t_i, length)
    out.mkdir(parents=True, exist_ok=True)
    table = out / "work_precision_python.csv"
    with open(table, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS.split())
        writer.writerows(rows)
    command = [program, "work-precision", str(arguments.case), "--plot", "--rows", str(table), "--out", str(out)]
    if arguments.gamma_f:
        command += ["--gamma-f", arguments.gamma_f]
    sys.exit(subprocess.run(command).returncode)


if __name__ == "__main__":
    main()
