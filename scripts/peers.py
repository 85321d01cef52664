#!/usr/bin/env python3
# /// script
# requires-python = ">=3.11"
# dependencies = ["heyoka>=7", "mpmath", "numpy"]
# ///
"""The best times of heyoka on motions of benches/engine.rs and two more, for errors at the end of a run.

    uv run scripts/peers.py [NAME ...]

Prints for every error that is allowed the fastest setting that meets it, with its order, its steps and the error found:
first of Hamilton's equations by hand, with settings by tolerance, which is what this program integrates; and then of
the equations that are best for heyoka, some of them in other variables, and with a constant among the variables, too.
Steps follow the largest variable, so that such a constant makes those of an order longer. All are in equations.py. A
time is the least of many runs with one integrator, which was compiled before. An error is the largest of all
coordinates at the end, each relative to its largest value on the way, against a run in 160 bits of equations that
are not written by hand. To begin a run and to end it takes some time without any step. All times have it, and the last
line of a motion tells how much it is. """

import itertools
import math
import sys
import time
import tomllib
from pathlib import Path

import heyoka as hy
import numpy as np
from equations import Scene

CASES = Path(__file__).resolve().parent.parent / "cases"
KEPLER = {"x": 0.1, "y": 0.0, "x_dot": 0.0, "y_dot": "sqrt(19)"}
# Each has a name, the case that gives its equations and start, a length, and what its start has instead.
MOTIONS = [
    ("henon-heiles", "scenes/henon-heiles", 1000.0, {}),
    ("kerr-400", "scenes/kerr-inclined", 400.0, {}),
    ("kerr-2000", "scenes/kerr-inclined", 2000.0, {}),
    ("schwarzschild", "scenes/schwarzschild-orbit", 2000.0, {}),
    ("crossed-fields", "scenes/crossed-fields", 20.0, {}),
    ("kepler", "scenes/kepler", 2.0 * math.pi, KEPLER),
    ("quartic-1", "quartic", 1.0, {}),
    ("quartic-1000", "quartic", 1000.0, {}),
]
ERRORS = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
ORDERS = range(4, 26)
CONSTANTS = [0.0, 1e2, 1e3, 1e4, 1e6]
BITS = 160  # The run that errors are measured against has this many.
PATIENCE = 0.05  # These are the seconds that a setting gets to be timed.


class Run:
    """Runs of a world to its end, from the start again each time."""

    def __init__(self, world, length, order, constant):
        system, start, self.length = world.system, begin(world), length
        if constant:
            system, start = [*system, (hy.make_vars("constant"), hy.expression(0.0))], [*start, constant]
        # From this tolerance heyoka computes the order, and from the order its steps.
        tolerance, self.start = 1.0001 * math.exp(2.0 * (1.0 - order)), np.array(start)
        self.integrator = hy.taylor_adaptive(system, self.start, tol=tolerance, fast_math=True)
        self.state = self.integrator.state

    def __call__(self, length=None):
        self.integrator.time, self.state[:] = 0.0, self.start
        return self.integrator.propagate_until(self.length if length is None else length)

    def seconds(self, patience, **arguments):
        begun, least = time.perf_counter(), math.inf
        while time.perf_counter() - begun < patience:
            one = time.perf_counter()
            self(**arguments)
            least = min(least, time.perf_counter() - one)
        return least


def begin(world):
    return [*world.start, *[0.0] * (len(world.system) - len(world.start))]


def coordinates(world, state):
    """Those that are integrated."""
    return [q + float(origin) for q, origin in zip(world.place(state), world.origin) if q is not None]


def truth(world, length):
    """The end, and the largest value of each coordinate at a hundred places on the way."""
    start, tolerance = np.array([hy.real(x, BITS) for x in begin(world)]), hy.real(2.0 ** (10 - BITS), BITS)
    integrator = hy.taylor_adaptive(world.system, start, tol=tolerance, fp_type=hy.real, compact_mode=True)
    sizes = np.zeros(len(coordinates(world, start)))
    for gamma in np.linspace(0.0, length, 101):
        integrator.propagate_until(hy.real(gamma, BITS))
        end = coordinates(world, integrator.state)
        sizes = np.maximum(sizes, np.abs([float(q) for q in end]))
    return end, sizes


def measured(world, length, end, sizes, constants):
    """All settings that end with an error that counts: seconds, error, setting and run."""
    for constant, order in itertools.product(constants, ORDERS):
        run = Run(world, length, order, constant)
        steps = run()[3]
        off = [float(hy.real(q, BITS) - wanted) for q, wanted in zip(coordinates(world, run.state), end)]
        error = np.max(np.abs(off) / sizes)
        if error <= max(ERRORS):
            yield run.seconds(PATIENCE), error, (order, constant, steps), run


def main():
    head = f"{'error':>6} {'us':>8} {'order':>5} {'steps':>6} {'found':>7}    "
    print(f"{'':15} {head} {'us':>8} {'order':>5} {'steps':>6} {'found':>7} constant")
    for name, file, length, start in MOTIONS:
        if sys.argv[1:] and not any(text in name for text in sys.argv[1:]):
            continue
        case = tomllib.loads((CASES / f"{file}.toml").read_text(encoding="utf-8"))
        case["initial"] |= start
        exact = truth(Scene(case, by_hand=False), length)
        settings = [
            [setting for setting in measured(Scene(case, by_hand=form), length, *exact, constants)]
            for form, constants in (("hamiltonian", CONSTANTS[:1]), (True, CONSTANTS))
        ]
        for error in ERRORS:
            line = f"{name:15} {error:6.0e}"
            for group in settings:
                good = [one for one in group if one[1] <= error]
                if not good:
                    line += f" {'-':>8}" + " " * 25
                    continue
                _, found, (order, constant, steps), run = min(good, key=lambda one: one[0])
                line += f" {1e6 * run.seconds(10.0 * PATIENCE):8.2f} {order:5} {steps:6} {found:7.0e}    "
                line += f"{constant:.0e}" if group is settings[1] else ""
            print(line, flush=True)
        print(f"{name:15} {'none':>6} {1e6 * settings[0][0][3].seconds(PATIENCE, length=0.0):8.2f}", flush=True)


if __name__ == "__main__":
    main()
