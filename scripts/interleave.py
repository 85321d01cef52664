#!/usr/bin/env python3
"""Compares two builds of the bench `solve`, run in turns: the ratio of the shortest times, after over before.

    scripts/interleave.py BEFORE AFTER [--only TEXT] [--rounds N]

BEFORE and AFTER are bench programs, as `cargo bench --no-run --bench solve` names them. Build one in a clone of the
commit before. Times of different minutes are not comparable on shared hardware; ratios of minima within one run are,
to about two per cent.
"""

import argparse
import collections
import re
import subprocess

UNITS = {"ns": 1.0, "µs": 1e3, "ms": 1e6, "s": 1e9}


def shortest(program, only):
    """The shortest time of every bench in nanoseconds, from the tree that divan prints."""
    command = [program, "--bench", "--sample-count", "200", "--max-time", "0.5", *([only] if only else [])]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    times, path = {}, []
    for line in printed.splitlines():
        if not (row := re.match(r"^([│ ]*)[├╰]─ (.+?)(?:\s{2,}|$)(.*)$", line)):
            continue
        path = path[: len(row[1]) // 3] + [row[2].strip()]
        if time := re.match(r"([\d.]+) (ns|µs|ms|s)\b", row[3]):
            times["/".join(path)] = float(time[1]) * UNITS[time[2]]
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--only", metavar="TEXT", help="benches with this in their names")
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="turns of both (default: 3)")
    arguments = parser.parse_args()
    least = [collections.defaultdict(lambda: float("inf")) for _ in range(2)]
    for _ in range(arguments.rounds):
        for times, program in zip(least, [arguments.before, arguments.after]):
            for name, time in shortest(program, arguments.only).items():
                times[name] = min(times[name], time)
    print("  ratio     before ns      after ns  bench")
    for name in least[0]:
        if name in least[1]:
            print(f"{least[1][name] / least[0][name]:7.3f} {least[0][name]:13.1f} {least[1][name]:13.1f}  {name}")


if __name__ == "__main__":
    main()
