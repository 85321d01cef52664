#!/usr/bin/env python3
"""Kills every command that writes files at random moments, fills its disk and takes its memory away.

    python3 scripts/faults.py [--program PATH] [--rounds N] [--seed SEED]

Each command has two settings, whose files differ, and both write into one folder.

* Killed (signal 9): if there is a summary, every file must belong to the setting that the summary names. A table of
  `run --vary` must go on to the very table that an undisturbed run writes.
* Full disk: a small file system in memory, on Linux and as root. The program must end with exit code 0 or 1, and leave
  one whole set or none.
* Memory: address space limited to random sizes. The program must end with a documented exit code, not be aborted.

What was found is printed, and the exit code is 1 if there was a fault.
"""

import argparse
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Name of the command, what both settings have in common, and what makes them differ.
COMMANDS = {
    "run": (["run", "quartic"], ["--set", "grid.n_gamma=40"], ["--set", "grid.n_gamma=60"]),
    "run --plot": (["run", "quartic", "--plot"], ["--set", "grid.n_gamma=40"], ["--set", "grid.n_gamma=60"]),
    "run scene": (["run", "kepler", "--plot"], ["--set", "grid.windows=4"], ["--set", "grid.windows=6"]),
    "converge": (["converge", "quartic"], ["--n-gamma", "16,32,64"], ["--n-gamma", "24,48,96"]),
    "work-precision": (
        ["work-precision", "quartic", "--gamma-f", "1"],
        ["--methods", "GLL8"],
        ["--methods", "RK4"],
    ),
    "stability": (
        ["stability", "quartic", "--gamma-f", "5", "--delta-gamma", "0.1,0.2"],
        ["--methods", "GLL8"],
        ["--methods", "RK4"],
    ),
}
VARY = ["run", "kepler", "--vary", "initial.y_dot=0.8:1.2:100"]
# Seconds after which a program counts as one that does not end.
PATIENCE = 60
DOCUMENTED = {0, 1, 2, 3, 4, 130}
# Words of files that change from run to run.
TIMES = ("seconds", "elapsed", "time")


def files(folder):
    """The files that are a result, by name."""
    return {path.name: path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")}


def of_speed(text):
    """The fronts in the summary of a study of speed."""
    try:
        return json.loads(text)["fronts"]
    except (ValueError, LookupError, TypeError):
        return None


def mark(path):
    """What tells the files of two settings apart, without columns and keys of times."""
    text = path.read_text(errors="replace")
    if path.suffix == ".csv":
        rows = [row.split(",") for row in text.splitlines()]
        if rows and {"method", "family"} & set(rows[0]):
            # Which rows a study of speed has depends on how fast it was.
            column = next(k for k, name in enumerate(rows[0]) if name in ("method", "family"))
            return ",".join(sorted({row[column] for row in rows[1:]}))
        keep = [k for k, name in enumerate(rows[0]) if not any(word in name for word in TIMES)] if rows else []
        text = "\n".join(",".join(row[k] for k in keep if k < len(row)) for row in rows)
    elif fronts := of_speed(text):
        # So does what is fastest.
        return ",".join(sorted({point["method"] for point in fronts}))
    elif path.suffix in (".json", ".svg"):
        text = "\n".join(line for line in text.splitlines() if not any(word in line for word in TIMES))
    return hashlib.sha256(text.encode()).hexdigest()


class Command:
    """One command with its two settings."""

    def __init__(self, program, name):
        self.name, self.program = name, program
        common, *self.settings = COMMANDS[name]
        self.lines = [[program, *common, *setting, "--quiet"] for setting in self.settings]

    def run(self, which, folder, before=()):
        line = [*before, *self.lines[which], "--out", str(folder)]
        return subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def reference(self, folder):
        """How long both settings take, and the marks of their files that are the same whenever they run."""
        self.marks, self.seconds = [], []
        for which in range(2):
            twice = []
            for _ in range(2):
                shutil.rmtree(folder, ignore_errors=True)
                begin = time.perf_counter()
                process = self.run(which, folder)
                if process.wait() != 0:
                    raise SystemExit(f"{self.name}: {process.stderr.read().decode()}")
                self.seconds.append(time.perf_counter() - begin)
                twice.append({name: mark(path) for name, path in files(folder).items()})
            one, other = twice
            # A file with measured times says nothing but that it is there.
            self.marks.append({name: one[name] if one[name] == other[name] else None for name in one})

    def is_set(self, folder):
        """Whether the folder holds one whole set, or none."""
        found = files(folder) if folder.exists() else {}
        if "summary.json" not in found:
            return "none"
        marks = {name: mark(path) for name, path in found.items()}
        for which, expected in enumerate(self.marks):
            if marks.keys() == expected.keys() and all(v is None or marks[k] == v for k, v in expected.items()):
                return "AB"[which]
        return None


def ended(process):
    """The exit code and what was said; a program that does not end is killed, and its code is "hangs"."""
    try:
        message = process.communicate(timeout=PATIENCE)[1].decode()
        return process.returncode, message
    except subprocess.TimeoutExpired:
        process.kill()
        return "hangs", process.communicate()[1].decode()


def is_told(message):
    return any(line.startswith("error:") for line in message.splitlines())


def kill(command, folder, rounds):
    """Kills the command at random moments; how often the folder held which set, and faults."""
    shutil.rmtree(folder, ignore_errors=True)
    left, faults = {}, []
    for k in range(rounds):
        process = command.run(k % 2, folder)
        time.sleep(random.uniform(0.0, 1.1 * max(command.seconds)))
        process.kill()
        process.wait()
        state = command.is_set(folder)
        left[state] = left.get(state, 0) + 1
        if state is None:
            faults.append(f"a mixture in round {k}: {sorted(files(folder))}")
    return left, faults


def vary(program, folder, rounds):
    """Kills a table of runs until it is done; it must be the table of an undisturbed run."""
    line = [program, *VARY, "--quiet", "--out"]
    begin = time.perf_counter()
    quietly = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.run([*line, str(folder / "whole")], check=True, **quietly)
    seconds = time.perf_counter() - begin
    whole, faults, kills = (folder / "whole/runs.csv").read_bytes(), [], 0
    while kills < rounds:
        shutil.rmtree(folder / "part", ignore_errors=True)
        while kills < rounds:
            process = subprocess.Popen([*line, str(folder / "part")], **quietly)
            try:
                process.wait(timeout=random.uniform(0.0, 0.6 * seconds))
                break
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
                kills += 1
        subprocess.run([*line, str(folder / "part")], check=True, **quietly)
        if (folder / "part/runs.csv").read_bytes() != whole:
            faults.append("a continued table differs")
    return {"kills": kills}, faults


def full_disk(command, folder, rounds):
    """Runs both settings on a file system that is too small for them, or just large enough."""
    disk, left, faults = folder / "disk", {}, []
    for k in range(rounds):
        disk.mkdir(parents=True, exist_ok=True)
        size = random.choice([8, 16, 24, 32, 48, 64, 96, 128, 192, 256]) * 1024
        mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", disk]
        if subprocess.run(mount, capture_output=True).returncode:
            return {"not allowed here": 1}, []
        try:
            before = "none"
            for which in (0, 1, k % 2):
                process = command.run(which, disk / "out")
                code, message = ended(process)
                state = command.is_set(disk / "out")
                # An error may come after the last file, or leave nothing of what it was to replace.
                kept = state is not None if code else state == "AB"[which]
                if code not in (0, 1) or not kept or (code and not is_told(message)):
                    faults.append(f"exit {code}, {before} -> {state}, {size} bytes: {message.strip()[:200]}")
                left[code] = left.get(code, 0) + 1
                before = state
        finally:
            subprocess.run(["umount", disk], check=True)
    return left, faults


def limited(most):
    """What stands before a command that may have so many kilobytes of address space."""
    return ["sh", "-c", f'ulimit -v {most} && exec "$@"', "sh"]


def least_memory(program):
    """The kilobytes of address space without which the system cannot load the program."""
    low, high = 0, 1 << 20
    while high - low > 64:
        middle = (low + high) // 2
        is_enough = subprocess.run([*limited(middle), program, "--help"], capture_output=True).returncode == 0
        low, high = (low, middle) if is_enough else (middle, high)
    return high


def memory(command, folder, rounds, least):
    """Limits the address space to random sizes with which the program can be loaded."""
    left, faults = {}, []
    for k in range(rounds):
        most = least + int(2 ** random.uniform(6.0, 18.0))
        process = command.run(k % 2, folder, limited(most))
        code, message = ended(process)
        left[code] = left.get(code, 0) + 1
        if code not in DOCUMENTED or (code and not is_told(message)):
            faults.append(f"exit {code} with {most - least} kB more than it takes to load: {message.strip()[:200]}")
    return left, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/geodesic-ivp")
    parser.add_argument("--rounds", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    random.seed(arguments.seed)
    program, rounds = os.path.abspath(arguments.program), arguments.rounds
    count, least = 0, least_memory(program)
    with tempfile.TemporaryDirectory() as root:
        root = Path(root)

        def report(name, kind, outcome):
            nonlocal count
            left, faults = outcome
            count += len(faults)
            told = ", ".join(f"{key}: {value}" for key, value in sorted(left.items(), key=str))
            print(f"{name:15} {kind:10} {told}", *faults[:5], sep="\n    fault: ", flush=True)

        for name in COMMANDS:
            command, folder = Command(program, name), root / name.replace(" ", "-")
            command.reference(folder)
            report(name, "killed", kill(command, folder, rounds))
            report(name, "full disk", full_disk(command, folder, max(rounds // 4, 1)))
            report(name, "memory", memory(command, folder, rounds, least))
        report("run --vary", "killed", vary(program, root / "vary", max(rounds // 4, 1)))
    print(f"{count} faults")
    sys.exit(1 if count else 0)


if __name__ == "__main__":
    main()
