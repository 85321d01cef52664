#!/usr/bin/env python3
# /// script
# requires-python = ">=3.11"
# dependencies = ["heyoka>=7", "mpmath", "numpy", "scipy>=1.13"]
# ///
"""`geodesic-ivp work-precision` with rows from Python beside it: heyoka's Taylor method and SciPy's solve_ivp.

    uv run scripts/work-precision.py CASE [--set KEY=VALUE] [--gamma-f L,L] [--out DIR] [--longest SECONDS]

Measures these methods on the case's world-line, then has the program measure its own in the same minute, rank all
together (`--rows`) and draw them. CASE is what the program takes for one. Everything else works without Python.

The same rules: t, x and w at ten equally spaced values of γ; errors against the integrator of expectations.py, which
has 24 digits; minimum and median of repeated runs, in turns. The equations are those of equations.py. heyoka compiles
before, and its integrator is reused: only the integration is timed. fast_math saves a fifth to a third of the time and
changes rounding only; compact_mode, high_accuracy, slp_vectorize and force_avx512 take longer. Steps follow the largest
variable, to which t belongs and grows: tolerances below rounding make up for that. "heyoka 1e3" has a constant of this
size as a variable, which makes steps of the same order longer and pays off at loose tolerances. "heyoka×2" is what its
error costs: a run, and the one with a hundredth of its tolerance, which is the result. SciPy has t outside its error
norm, and right-hand sides in plain Python. Of Newton's law nobody integrates s and t, which is γ: their errors are
written as 0. """

import argparse
import csv
import math
import shutil
import subprocess
import sys
import time
import tomllib
from decimal import Decimal, getcontext
from pathlib import Path

import heyoka as hy
import numpy as np
from equations import Scene
from expectations import DIGITS, integrate
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

getcontext().prec = 50
OUTPUTS = 10
LONGEST = 0.5  # seconds of a run; the next tolerance of its method is not tried
ROUNDS = 15
ANY = 1e10  # an absolute tolerance that takes t out of the norm
BEHIND = "delta_k_max seconds_min seconds_median evaluations points status gamma_f".split()


def heyoka(world, length, tolerance, constant=0.0):
    initial = np.array([*world.start, *[0.0] * (len(world.system) - len(world.start)), constant])
    system = [*world.system, (hy.make_vars("constant"), hy.expression(0.0))]
    integrator = hy.taylor_adaptive(system, initial, tol=tolerance, fast_math=True)
    grid, state = np.linspace(0.0, length, OUTPUTS + 1), integrator.state

    def run():
        integrator.time, state[:] = 0.0, initial
        # (outcome, shortest step, longest step, steps, callback, states)
        outcome = integrator.propagate_grid(grid)
        return outcome[5][1:], outcome[3]

    return run, lambda steps: steps * integrator.order


def scipy(method):
    def make(world, length, tolerance):
        f, grid, calls = world.python(), np.linspace(0.0, length, OUTPUTS + 1), [0]
        count = len(world.system) - len(world.start)
        atol = [tolerance] * len(world.start) + [ANY] * count
        arguments = dict(method=method, rtol=max(tolerance, 3e-14), atol=atol)

        def run():
            y, states, steps, calls[0] = [*world.start, *[0.0] * count], [], 0, 0
            if method != "Radau":
                solution = solve_ivp(f, (0.0, length), y, t_eval=grid[1:], **arguments)
                calls[0] = solution.nfev
                return solution.y.T, calls[0] // 12
            # Its dense output is of order 3 only.
            for a, b in zip(grid, grid[1:]):
                solution = solve_ivp(f, (a, b), y, **arguments)
                y, steps, calls[0] = solution.y[:, -1], steps + solution.t.size - 1, calls[0] + solution.nfev
                states.append(y)
            return np.array(states), steps

        return run, lambda _: calls[0]

    return make


METHODS = {"heyoka": heyoka, "heyoka 1e3": lambda *job: heyoka(*job, 1e3)}
METHODS |= {f"SciPy {method}": scipy(method) for method in ("DOP853", "LSODA", "Radau")}


def reference(world, grid, length):
    """γ_f and the coordinates at the points of output, by the integrator of expectations.py."""
    scene, rows = world.exact, []
    t_f = world.number(grid["t_f"]) if "t_f" in grid and length is None else None
    if t_f is not None:
        length = integrate(scene, mpf("1e18"), lambda y: y[scene.coordinates.index("t")] - t_f)[1]
    elif length is None:
        length = world.number(grid.get("gamma_f", 1)) - world.number(grid.get("gamma_i", 0))
    for _ in range(OUTPUTS):
        scene.state, _ = integrate(scene, mpf(length) / OUTPUTS)
        rows.append([Decimal(mp.nstr(q, DIGITS)) for q in scene.state[: len(world.coordinates)]])
    return float(length), rows


def attempt(world, exact, run):
    """Errors of the coordinates and of K."""
    states, steps = run()
    if len(states) < OUTPUTS or not np.isfinite(states).all():
        return None, steps
    errors = [0.0] * (len(world.coordinates) + 1)
    for state, wanted in zip(states, exact):
        place = zip(world.place(state), world.origin, wanted)
        found = [0 if q is None else abs(Decimal(float(q)) + origin - want) for q, origin, want in place]
        found.append(abs(world.delta_k(state)))
        errors = [max(a, float(b)) for a, b in zip(errors, found)]
    return errors, steps


def measure(world, exact, length):
    jobs = []
    sizes = [max(float(abs(row[a] - origin)) for row in exact) for a, origin in enumerate(world.origin)]
    for name, make in list(METHODS.items())[: 2 if len(world.coordinates) > 2 else None]:
        for digits in range(3, 19 if name.startswith("heyoka") else 16):
            run, count = make(world, length, 10.0**-digits)
            start = time.perf_counter()
            errors, steps = attempt(world, exact, run)
            seconds = time.perf_counter() - start
            is_off = any(error > 0.1 * size for error, size in zip(errors or [], sizes))
            status = "failed" if errors is None else "inaccurate" if is_off else "converged"
            errors = errors or [""] * (len(sizes) + 1)
            behind = [seconds, seconds, count(steps), steps, status, length]
            jobs.append((dict(zip(columns(world), [name, f"tol=1e-{digits}", *errors, *behind])), run, []))
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
    rows = [row for row, _, _ in jobs]
    return [*rows, *twice(rows)]


def twice(rows):
    """heyoka's runs, each with the one to a hundredth of its tolerance, in which the times of both are."""
    of = {(row["method"], row["setting"]): row for row in rows if row["method"].startswith("heyoka")}
    for (method, setting), row in of.items():
        finer = of.get((method, f"tol=1e-{int(setting.rpartition('-')[2]) + 2}"))
        if finer and finer["status"] == "converged":
            both = {name: row[name] + finer[name] for name in ("seconds_min", "seconds_median", "evaluations")}
            name = method.replace("heyoka", "heyoka×2")
            yield {**finer, **both, "method": name, "setting": f"{setting}, {finer['setting']}"}


def columns(world):
    return ["method", "setting", *(f"error_{name}" for name in world.coordinates), *BEHIND]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", metavar="CASE")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="as of the program")
    parser.add_argument("--gamma-f", metavar="L,L", help="lengths in gamma (default: the case's own)")
    parser.add_argument("--out", metavar="DIR", type=Path, help="default: results/<case>/work-precision")
    parser.add_argument("--longest", metavar="SECONDS", help="that a run of the program may take (default: its own)")
    parser.add_argument("--program", help="the geodesic-ivp to run (default: target/release/, or on the PATH)")
    arguments = parser.parse_args()
    built = Path(__file__).resolve().parent.parent / "target/release/geodesic-ivp"
    program = arguments.program or (str(built) if built.exists() else shutil.which("geodesic-ivp"))
    if not program:
        sys.exit("geodesic-ivp is not on the PATH: build it with cargo build --release")
    out = arguments.out or Path("results") / Path(arguments.case).stem / "work-precision"
    job = [arguments.case, *(part for setting in arguments.set for part in ("--set", setting))]
    # The case with every default.
    text = subprocess.run([program, "check", *job], check=True, capture_output=True, text=True).stdout
    case, rows = tomllib.loads(text, parse_float=str), []
    for length in arguments.gamma_f.split(",") if arguments.gamma_f else [None]:
        world = Scene(case)
        length, exact = reference(world, case["grid"], length)
        rows += measure(world, exact, length)
    out.mkdir(parents=True, exist_ok=True)
    table = out / "work_precision_python.csv"
    with open(table, "w", newline="") as file:
        writer = csv.DictWriter(file, columns(world))
        writer.writeheader()
        writer.writerows(rows)
    command = [program, "work-precision", *job, "--plot", "--rows", str(table), "--out", str(out)]
    for option, value in (("--gamma-f", arguments.gamma_f), ("--longest", arguments.longest)):
        command += [option, value] if value else []
    sys.exit(subprocess.run(command).returncode)


if __name__ == "__main__":
    main()
