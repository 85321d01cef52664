"""Sections of docs/measured.md: commands, tables, and how numbers are written."""

import csv
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import SimpleNamespace

ROOT = Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"
SECTIONS = {}
# The program that is measured.
chosen = SimpleNamespace(program=ROOT / "target/release/geodesic-ivp")


def section(title):
    """A section of the page: a function that returns its text."""

    def register(make):
        SECTIONS[make.__name__.replace("_", "-")] = (title, make)
        return make

    return register


class Results:
    """What a command wrote, in a folder of its own, and the command as a user would type it."""

    def __init__(self, command, *arguments, ends=(0,)):
        self.folder = Path(tempfile.mkdtemp(prefix="measure-"))
        self.line = " ".join(["geodesic-ivp", command, *map(quoted, arguments)])
        print(f"  {self.line}", file=sys.stderr)
        line = [chosen.program, command, *arguments, "--out", self.folder]
        done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True)
        if done.returncode not in ends:
            sys.exit(f"{self.line}\nended with {done.returncode}: {done.stderr}")
        self.code = done.returncode
        self.reread()

    def reread(self):
        path = self.folder / "summary.json"
        self.summary = json.loads(path.read_text()) if path.exists() else {}

    def rows(self, name):
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def number(self, key):
        return float(self.summary[key])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.folder)


def quoted(argument):
    return f"'{argument}'" if re.search(r"[\s{}\"]", argument) else argument


def sets(text):
    """KEY=VALUE … as arguments."""
    return [part for pair in text.split() for part in ("--set", pair)]


def run(case, changes="", *more, ends=(0,)):
    return Results("run", case, *sets(changes), *more, ends=ends)


def table(head, rows):
    lines = [head, *rows]
    lines = ["| " + " | ".join(map(str, line)) + " |" for line in lines]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]]) + "\n"


def short(number, digits=1):
    """1.2e-3, or nothing where nothing was measured."""
    if number in (None, ""):
        return ""
    return re.sub(r"e([+-])0*(\d)", lambda m: f"e{m[1].replace('+', '')}{m[2]}", f"{float(number):.{digits}e}")


def duration(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("μs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.2g} μs"
