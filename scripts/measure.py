#!/usr/bin/env python3
"""Draws the pictures of docs/measured.md again and writes every number of the page.

    scripts/measure.py [SECTION …] [--program PATH] [--list]

Without SECTION everything is measured: half an hour on two cores. With SECTIONs the others stay as they are on the
page. The sections are in scripts/measured/. This needs Python 3.11, cargo unless a program is given that has been
built, and uv for the sections on speed, as heyoka and SciPy stand beside the program there.
"""

import argparse
import datetime
import platform
import re
import subprocess
import sys
import textwrap
from pathlib import Path

# The order of imports is that of the page.
from measured import schemes, studies  # noqa: F401
from measured.page import DOCS, ROOT, SECTIONS, chosen

PAGE = DOCS / "measured.md"
INTRODUCTION = """# Measured

`scripts/measure.py` writes this page and draws its pictures; do not edit it by hand. `scripts/measure.py SECTION`
measures a section again, and `--list` names them; such a section names its commit. The machine is a shared one with two
cores: believe ratios, and times within tens of per cent.
"""


def heading():
    try:
        info = Path("/proc/cpuinfo").read_text()
        machine = re.search(r"model name\s*: (.*)", info)[1]
    except (OSError, TypeError):
        machine = platform.processor() or platform.machine()
    def git(*command):
        return subprocess.run(["git", *command], cwd=ROOT, capture_output=True, text=True).stdout.strip()

    # What is written here changes no number.
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", ":(exclude)docs")
    commit = git("rev-parse", "--short", "HEAD") + ("-dirty" if changed else "")
    return f"*{datetime.date.today()}, commit {commit}, {machine}.*"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", metavar="SECTION", nargs="*", help="what to measure (default: everything)")
    parser.add_argument("--program", type=Path, help="the geodesic-ivp to run (default: it is built)")
    parser.add_argument("--list", action="store_true", help="name the sections")
    arguments = parser.parse_args()
    if arguments.list:
        return print("\n".join(f"{name:16} {title}" for name, (title, _) in SECTIONS.items()))
    if unknown := [name for name in arguments.sections if name not in SECTIONS]:
        sys.exit(f"no section is called {', '.join(unknown)}: there are {', '.join(SECTIONS)}")
    if arguments.program:
        chosen.program = arguments.program.resolve()
    else:
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
    page = PAGE.read_text() if PAGE.exists() else ""
    texts = dict(re.findall(r"^## (.*?)\n\n(.*?)(?=\n## |\Z)", page, re.S | re.M))
    # Once: this script's own page would make the tree look changed.
    when_and_where = heading()
    head = page.split("\n## ")[0] if arguments.sections else f"{INTRODUCTION}\n{when_and_where}\n"
    is_of_page = when_and_where in head
    for name in arguments.sections or SECTIONS:
        print(name, file=sys.stderr)
        title, make = SECTIONS[name]
        text, rest = make().split("\n\n", 1)
        # Long words are commands.
        text = text if is_of_page else f"{when_and_where} {text}"
        text = textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)
        texts[title] = f"{text}\n\n{rest}"
        known = [f"## {title}\n\n{texts[title]}" for title, _ in SECTIONS.values() if title in texts]
        PAGE.write_text(head + "\n" + "\n".join(known))


if __name__ == "__main__":
    main()
