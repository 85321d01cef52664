#!/usr/bin/env python3
# /// script
# requires-python = ">=3.11"
# dependencies = ["heyoka>=7", "mpmath", "numpy", "rebound>=4,<5"]
# ///
"""A hundred turns of a planet of eccentricity 0.9: this program beside heyoka and REBOUND's IAS15.

    uv run scripts/kepler.py [--program PATH] [--json]

DOP853 is this program's own, as `work-precision` times it on the same case, with the same ten points. All integrate Newton's law in the plane and hand out ten points, the last of them the start again. Errors of the
position are against Kepler's equation in 40 digits. This program's time is `solve_seconds`, with certificate and all
that it stores; heyoka's and REBOUND's is that of a compiled integrator that was set up before. The least of several
runs counts, all settings in turns.

heyoka integrates Hamilton's equations, IAS15 a massless planet around a fixed sun, and this program the geodesic with
one of three conformal factors: none, 1/r, and the root of the largest second derivative of V, which is r^(-3/2). With
the last of them a window would turn by the same angle everywhere. In Levi-Civita's coordinates x + iy = (u + iv)^2 with
the factor 1/r the plane is flat. The same equations are also given to heyoka: u'' = -u/4, v'' = -v/4, t' = u^2 + v^2.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import heyoka as hy
import mpmath
import numpy as np
import rebound

ECCENTRICITY = 0.9
TURNS = 100
POINTS = 10
ROUNDS = 7
LENGTH = 2.0 * math.pi * TURNS
FACTORS = {"1": None, "1/r": "1/sqrt(x^2 + y^2)", "r^(-3/2)": "1/sqrt((x^2 + y^2)*sqrt(x^2 + y^2))"}
FLAT = "own, Levi-Civita"
ACCURACIES = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10]
TOLERANCES = [1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14]
EPSILONS = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9]
ERRORS = [1e-6, 1e-7, 1e-8, 1e-9]

CASE = """
[potential]
coordinates = ["x", "y"]
formula = "-1/sqrt(x^2 + y^2)"
{conformal}
[particle]
law = "newtonian"
[initial]
x = {x!r}
y = 0.0
x_dot = 0.0
y_dot = {y_dot!r}
"""

LEVI_CIVITA = """
[metric]
coordinates = ["t", "u", "v", "s"]
components = {{ "t t" = "-2/(u^2 + v^2)^2", "t s" = "1/(u^2 + v^2)", "u u" = "-4", "v v" = "-4" }}
[initial]
t_dot = {x!r}
u = "sqrt({x!r})"
v = 0.0
u_dot = 0.0
v_dot = "{y_dot!r}*sqrt({x!r})/2"
norm = "null"
solve = {{ s_dot = "+" }}
"""

GRID = """
[grid]
t_f = {length!r}
[solver]
accuracy = {accuracy!r}
"""


def exact(t):
    """Kepler's equation E − e sin E = t, and the point of the ellipse."""
    with mpmath.workdps(40):
        e, turn = mpmath.mpf(repr(ECCENTRICITY)), 2 * mpmath.pi
        mean = mpmath.mpf(t) - turn * mpmath.nint(mpmath.mpf(t) / turn)
        anomaly = mpmath.findroot(lambda E: E - e * mpmath.sin(E) - mean, mean + mpmath.sign(mean) / 2)
        return float(mpmath.cos(anomaly) - e), float(mpmath.sqrt(1 - e**2) * mpmath.sin(anomaly))


TIMES = np.linspace(0.0, LENGTH, POINTS + 1)
TRUTH = np.array([exact(t) for t in TIMES[1:]])
START = [1.0 - ECCENTRICITY, 0.0, 0.0, math.sqrt((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY))]


def own(program, factor, accuracy):
    is_flat = factor == FLAT
    conformal = FACTORS.get(factor)
    text = (LEVI_CIVITA if is_flat else CASE) + GRID
    text = text.format(
        conformal=f'conformal = "{conformal}"' if conformal else "",
        x=START[0], y_dot=START[3], length=LENGTH, accuracy=accuracy,
    )
    names = ("u", "v") if is_flat else ("x", "y")
    point = lambda u, v: (u * u - v * v, 2.0 * u * v) if is_flat else (u, v)
    folder = Path(tempfile.mkdtemp(prefix="kepler-"))
    (folder / "case.toml").write_text(text)

    def run():
        step = f"0:{LENGTH!r}:{LENGTH / POINTS!r}"
        line = [program, "run", str(folder / "case.toml"), "--quiet", "--sample-t", step, "--out", str(folder / "out")]
        if subprocess.run(line, capture_output=True).returncode != 0:
            return math.inf, None
        summary = json.loads((folder / "out/summary.json").read_text())
        rows = [line.split(",") for line in (folder / "out/samples.csv").read_text().split()]
        columns = [rows[0].index(name) for name in names]
        points = [point(*(float(row[column]) for column in columns)) for row in rows[2 : POINTS + 1]]
        end = point(*(float(summary["final"][name]) for name in names))
        return summary["solve_seconds"], np.array([*points, end])

    return run


def heyoka(tolerance):
    x, y, u, v = hy.make_vars("x", "y", "u", "v")
    cube = (x * x + y * y) ** -1.5
    integrator = hy.taylor_adaptive([(x, u), (y, v), (u, -x * cube), (v, -y * cube)], START, tol=tolerance)

    def run():
        integrator.time = 0.0
        integrator.state[:] = START
        begin = time.perf_counter()
        outcome = integrator.propagate_grid(TIMES)
        return time.perf_counter() - begin, outcome[5][1:, :2]

    return run


def heyoka_flat(tolerance):
    """A turn is 2π of γ, and ends at the periapsis. Positions are compared at the time that was found for them."""
    u, v, u_dot, v_dot, t = hy.make_vars("u", "v", "u_dot", "v_dot", "t")
    start = [math.sqrt(START[0]), 0.0, 0.0, START[3] * math.sqrt(START[0]) / 2.0, 0.0]
    equations = [(u, u_dot), (v, v_dot), (u_dot, -u / 4.0), (v_dot, -v / 4.0), (t, u * u + v * v)]
    integrator = hy.taylor_adaptive(equations, start, tol=tolerance)

    def run():
        integrator.time = 0.0
        integrator.state[:] = start
        begin = time.perf_counter()
        outcome = integrator.propagate_grid(TIMES)
        seconds = time.perf_counter() - begin
        u, v, _, _, t = outcome[5][1:].T
        late = np.array([exact(t) for t in t]) - TRUTH
        return seconds, np.column_stack([u * u - v * v, 2.0 * u * v]) - late

    return run


def ias15(epsilon):
    def run():
        simulation = rebound.Simulation()
        simulation.add(m=1.0)
        simulation.add(m=0.0, x=START[0], vy=START[3])
        simulation.integrator = "ias15"
        simulation.ri_ias15.epsilon = epsilon
        points = []
        begin = time.perf_counter()
        for t in TIMES[1:]:
            simulation.integrate(t)
            points.append((simulation.particles[1].x, simulation.particles[1].y))
        return time.perf_counter() - begin, np.array(points)

    return run


def dop853(program):
    """Rows of `work-precision`: seconds and errors of the position, by tolerance."""
    text = CASE.format(conformal="", x=START[0], y_dot=START[3]) + f"[grid]\ngamma_f = {LENGTH!r}\n"
    text += 'windows = 1500\n[scheme]\nsbp = "GLL20"\n'
    folder = Path(tempfile.mkdtemp(prefix="kepler-"))
    (folder / "case.toml").write_text(text)
    line = [program, "work-precision", str(folder / "case.toml"), "--quiet", "--methods", "DOP853"]
    subprocess.run([*line, "--out", str(folder / "out")], check=True, capture_output=True)
    with open(folder / "out/work_precision.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["method"] == "DOP853" and row["error_x"]]
    error = lambda row: max(float(row["error_x"]), float(row["error_y"]))
    return {("DOP853", row["setting"]): (float(row["seconds_min"]), error(row)) for row in rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/geodesic-ivp")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    arguments = parser.parse_args()
    program = arguments.program
    runs = {("own, factor " + factor, a): own(program, factor, a) for factor in FACTORS for a in ACCURACIES}
    runs |= {(FLAT, a): own(program, FLAT, a) for a in ACCURACIES}
    runs |= {("heyoka", tolerance): heyoka(tolerance) for tolerance in TOLERANCES}
    runs |= {("heyoka, Levi-Civita", tolerance): heyoka_flat(tolerance) for tolerance in TOLERANCES}
    runs |= {("IAS15", epsilon): ias15(epsilon) for epsilon in EPSILONS}
    least, errors = dict.fromkeys(runs, math.inf), {}
    for _ in range(ROUNDS):
        for key, run in runs.items():
            seconds, points = run()
            if points is not None:
                least[key] = min(least[key], seconds)
                errors[key] = float(np.abs(points - TRUTH).max())
    for key, (seconds, error) in dop853(program).items():
        least[key], errors[key] = seconds, error
    rows = []
    for error in ERRORS:
        row = {"error": error}
        for method in dict.fromkeys(method for method, _ in least):
            good = [least[key] for key in errors if key[0] == method and errors[key] <= error]
            row[method] = min(good) if good else None
        rows.append(row)
    if arguments.json:
        return json.dump(rows, sys.stdout)
    for row in rows:
        print("  ".join(f"{name} {value:.2e}" for name, value in row.items() if value is not None))


if __name__ == "__main__":
    main()
