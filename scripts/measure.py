#!/usr/bin/env python3
"""Draws the pictures in docs/ again and writes every number that the documentation quotes into docs/measured.md.

    scripts/measure.py [SECTION …] [--python] [--program PATH] [--list]

Without SECTION everything is measured: half an hour on two cores. With SECTIONs the others stay as they are in the
file. The sections are in scripts/measured/. Needs Python 3.11, and cargo unless a program is given that has been built;
with --python the charts of speed against accuracy have heyoka and SciPy beside them (scripts/work-precision.py, which
needs uv). Times are those of the machine that is named, others' work on it included.
"""

import argparse
import datetime
import platform
import re
import subprocess
import sys
from pathlib import Path

# The order of imports is that of the page.
from measured import schemes, studies  # noqa: F401
from measured.page import DOCS, ROOT, SECTIONS, chosen

PAGE = DOCS / "measured.md"
INTRODUCTION = """# Measured

Every number and table here, and every picture in this folder but `mesh.svg` and `charge.svg` (these are drawn by
`examples/first_picture.rs`), comes from `scripts/measure.py`; do not edit it by hand.
`scripts/measure.py SECTION` measures a section again, `--list` names them. Times are those of the machine and the
minutes that each section names, often a shared one: trust ratios, and absolute times within tens of per cent.
"""


def heading():
    try:
        info = Path("/proc/cpuinfo").read_text()
        machine = re.search(r"model name\s*: (.*)", info)[1] + f", {info.count('processor')} cores"
    except (OSError, TypeError):
        machine = platform.processor() or platform.machine()
    command = ["git", "describe", "--always", "--dirty"]
    commit = subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()
    return f"{datetime.date.today()}, commit {commit}, {machine}, {platform.system()}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", metavar="SECTION", nargs="*", help="what to measure (default: everything)")
    parser.add_argument("--python", action="store_true", help="heyoka and SciPy in the charts of speed")
    parser.add_argument("--program", type=Path, help="the geodesic-ivp to run (default: it is built)")
    parser.add_argument("--list", action="store_true", help="name the sections")
    arguments = parser.parse_args()
    if arguments.list:
        return print("\n".join(f"{name:30} {title}" for name, (title, _) in SECTIONS.items()))
    if unknown := [name for name in arguments.sections if name not in SECTIONS]:
        sys.exit(f"no section is called {', '.join(unknown)}: there are {', '.join(SECTIONS)}")
    if arguments.program:
        chosen.program = arguments.program.resolve()
    else:
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
    chosen.python = arguments.python
    page = PAGE.read_text() if PAGE.exists() else ""
    texts = {name: text for name, text in re.findall(r"<!-- begin (\S+) -->\n(.*?)<!-- end \1 -->", page, re.S)}
    # Once: this script's own page would make the tree look changed.
    when_and_where = heading()
    for name in arguments.sections or SECTIONS:
        print(name, file=sys.stderr)
        title, make = SECTIONS[name]
        texts[name] = f"## {title}\n\n*{when_and_where}*\n\n{make()}"
        known = [f"<!-- begin {name} -->\n{texts[name]}<!-- end {name} -->\n" for name in SECTIONS if name in texts]
        PAGE.write_text(INTRODUCTION + "\n" + "\n".join(known))


if __name__ == "__main__":
    main()
