#!/usr/bin/env python3
"""Draws the pictures in docs/ again and writes every measured number that the documentation quotes into docs/measured.md.

    scripts/measure.py [SECTION …] [--python] [--list]

Without SECTION everything is measured: a quarter of an hour on two cores. With SECTIONs the others stay as they are in the
file. Needs Python 3.11 and cargo; with --python the charts of speed against accuracy have heyoka and SciPy beside them
(scripts/work-precision.py, which needs uv). Times are those of the machine that is named, others' work on it included.
"""

import argparse
import csv
import datetime
import json
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/geodesic-ivp"
DOCS = ROOT / "docs"
PAGE = DOCS / "measured.md"
SECTIONS = {}


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
        self.line = " ".join(["geodesic-ivp", command, *(quoted(argument) for argument in arguments)])
        print(f"  {self.line}", file=sys.stderr)
        done = subprocess.run(
            [PROGRAM, command, *arguments, "--out", self.folder], cwd=ROOT, capture_output=True, text=True
        )
        if done.returncode not in ends:
            sys.exit(f"{self.line}\nended with {done.returncode}: {done.stderr}")
        self.output, self.code = done.stdout, done.returncode
        path = self.folder / "summary.json"
        # Numbers of many digits as they are written; exponents are all that is looked at.
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


def case_file(name):
    """The path of a shipped case from the project's folder."""
    folders = ("cases", "cases/hard")
    return next(path for path in (f"{folder}/{name}.toml" for folder in folders) if (ROOT / path).exists())


def run(case, changes="", *more, ends=(0,)):
    return Results("run", case_file(case), *sets(changes), *more, ends=ends)


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]) + "\n"


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


def code(*lines):
    return "```sh\n" + "\n".join(lines) + "\n```\n"


@section("The paper's numbers: slopes of the errors")
def orders():
    with Results("converge") as swept:
        text = code(swept.line) + "\n```text\n"
        return text + "".join(line + "\n" for line in swept.output.splitlines() if "written" not in line) + "```\n"


@section("How critical the points are: the largest entry of the gradient of the doubled action")
def gradient():
    rows = []
    for sbp in ("SBP21", "SBP42"):
        for system, most in (("physical-limit", 320_000), ("doubled", 32_000)):
            cells = []
            for n in (32, 320, 3200, 32_000, 320_000):
                if n > most:
                    cells.append("")
                    continue
                with run("quartic", f"scheme.sbp={sbp} solver.system={system} grid.n_gamma={n}") as one:
                    cells.append(short(one.number("gradient_norm")))
                    line = one.line
            rows.append([f"{sbp}, {system}", *cells])
    return code(line) + "\n" + table(["N =", "32", "320", "3 200", "32 000", "320 000"], rows)


@section("More digits: what is zero, and what is not")
def digits():
    measures = [
        ("ΔQ_t at all nodes but the last", "max_abs_delta_q_t_interior"),
        ("ΔG at the nodes not coupled to the last", "max_abs_delta_g_interior"),
        ("ΔQ_t with its multiplier correction, all nodes", "max_abs_delta_q_t_corrected"),
        ("λ1 … λ4", "multipliers"),
        ("largest entry of ∇E_IVP", "gradient_norm"),
    ]
    rows = [[name] for name, _ in measures] + [["ΔQ_t at the last node (quartic, SBP42)"]]
    for number in (16, 40, 60):
        largest, last = dict.fromkeys((key for _, key in measures), 0.0), ""
        for potential in ("linear", "quartic"):
            for sbp in ("SBP21", "SBP42"):
                for system in ("physical-limit", "doubled"):
                    with run(potential, f"scheme.sbp={sbp} solver.system={system} solver.digits={number}") as one:
                        for key in largest:
                            value = one.summary[key]
                            values = value[:4] if isinstance(value, list) else [value]
                            largest[key] = max(largest[key], *(abs(float(v)) for v in values))
                        if (potential, sbp) == ("quartic", "SBP42"):
                            last = short(one.number("delta_q_t_last"), 6)
        for row, value in zip(rows, [*map(short, largest.values()), last]):
            row.append(value)
    what = "The paper's four base cases (two potentials, two operators, N = 32) in both systems: the largest over all eight.\n"
    return what + "\n" + table(["", "16 digits", "40 digits", "60 digits"], rows)


@section("Strong form and weak form, quartic case")
def forms():
    names = [(sbp, form) for sbp in ("SBP21", "SBP42") for form in ("strong", "weak")]
    columns = []
    for sbp, form in names:
        base = f"scheme.sbp={sbp} scheme.form={form}"
        with run("quartic", base) as one, run("quartic", f"{base} solver.digits=40 solver.system=doubled") as exact:
            column = [
                short(abs(one.number("delta_q_t_last"))),
                short(max(float(exact.number("max_abs_delta_q_t_interior")), abs(exact.number("delta_q_t_last")))),
            ]
        with Results(
            "converge", "cases/quartic.toml", "--n-gamma", "65,129,257", "--sbp", sbp, "--form", form
        ) as swept:
            finest = swept.rows("convergence.csv")[-1]
            slopes = {row["quantity"]: f"{float(row['slope']):.2f}" for row in swept.rows("slopes.csv")}
            column += [short(finest["eps_x_final"]), short(finest["eps_t_final"])]
            column += [f"{slopes['eps_x_final']}, {slopes['eps_t_final']}", f"{slopes['eps_x_l2']}, {slopes['eps_t_l2']}"]
        with run("quartic", f"{base} grid.gamma_f=100.0 grid.n_gamma=2001", ends=(0, 3)) as long:
            column.append(short(long.number("max_abs_delta_k")) if long.code == 0 else "no critical point")
        columns.append(column)
    labels = ["ΔQ_t at the last node, N = 32", "max \\|ΔQ_t\\| over all nodes, N = 32, 40 digits, doubled"]
    labels += ["ε_x(γ_f), N = 257", "ε_t(γ_f), N = 257", "slopes of ε_x(γ_f), ε_t(γ_f) from N = 65"]
    labels += ["slopes of ε_x, ε_t in L2", "max \\|ΔK\\|, γ_f = 100, N = 2001"]
    return table(["", *(f"{sbp} {form}" for sbp, form in names)], [[a, *b] for a, b in zip(labels, zip(*columns))])


@section("Operators: orders and errors at γ_f, quartic case in 60 digits")
def operators():
    names = "SBP21,SBP42,SBP63,SBP84,GLL8,GLL16"
    sweep = ["--sbp", names, "--form", "strong,weak", "--n-gamma", "256,512,1024,2048", "--fit-range", "200:2100"]
    with Results("converge", "cases/quartic.toml", *sweep, *sets("solver.digits=60")) as swept:
        rows = []
        for sbp in names.split(","):
            cells = []
            for quantity, column in (("eps_x_final", "slope"), ("eps_t_final", "slope"), ("eps_x_final", "error")):
                for form in ("strong", "weak"):
                    at = [row for row in swept.rows("convergence.csv") if (row["sbp"], row["form"]) == (sbp, form)]
                    nearest = min(at, key=lambda row: abs(int(row["n_gamma"]) - 1024))
                    slope = next(
                        row["slope"]
                        for row in swept.rows("slopes.csv")
                        if (row["sbp"], row["form"], row["quantity"]) == (sbp, form, quantity)
                    )
                    cells.append(f"{float(slope):.2f}" if column == "slope" else short(nearest[quantity]))
            rows.append([sbp, *cells])
        head = ["", *(f"{what}, {form}" for what in ("slope of ε_x", "slope of ε_t", "ε_x at N = 1024") for form in ("strong", "weak"))]
        return code(swept.line) + "\n" + table(head, rows)


@section("Down to rounding: ε_x(γ_f) of the quartic case in f64")
def rounding():
    grids = "1024,16384,65536,262144,1000000,4000000"
    rows = []
    for form in ("strong", "weak"):
        sweep = ["--sbp", "SBP21,SBP42" if form == "strong" else "SBP42", "--form", form, "--n-gamma", grids]
        with Results("converge", "cases/quartic.toml", *sweep) as swept:
            points = swept.rows("convergence.csv")
            for sbp in dict.fromkeys(row["sbp"] for row in points):
                errors = [short(row["eps_x_final"]) for row in points if row["sbp"] == sbp]
                fitted = next(row for row in swept.rows("slopes.csv") if (row["sbp"], row["quantity"]) == (sbp, "eps_x_final"))
                slope = f"{float(fitted['slope']):.3f}, {fitted['n_min']} … {fitted['n_max']}" if fitted["slope"] else "none"
                rows.append([f"{sbp} {form}", *errors, slope])
    return table(["N =", *grids.split(","), "slope, fitted N"], rows)


@section("Which scheme for what: quartic case")
def tasks():
    spectral = "grid.gamma_f=1000.0 grid.windows=2000"
    even = "grid.gamma_f=100.0 grid.n_gamma=2001"
    runs = [
        ("exact charge at every node", run("quartic-weak")),
        ("windows of a spectral element", run("quartic-windows")),
        ("the same over 1000 units", run("quartic-windows", spectral)),
        ("an even grid in one block", run("quartic-sbp42", even)),
        ("the same, weak", run("quartic-sbp42", f"{even} scheme.form=weak")),
        ("not this: SBP21 on long runs", run("quartic", even)),
        ("nor this: SBP21, strong, in windows", run("quartic", "grid.gamma_f=100.0 grid.n_gamma=21 grid.windows=100")),
    ]
    head = ["", "command", "max \\|ΔQ_t\\|, interior", "max \\|ΔK\\|", "max \\|ΔK\\| at the ends", "solve"]
    keys = ["max_abs_delta_q_t_interior", "max_abs_delta_k", "max_abs_delta_k_ends"]
    return table(
        head,
        [
            [name, f"`{one.line}`", *(short(one.number(key)) for key in keys), duration(one.number("solve_seconds"))]
            for name, one in runs
        ],
    )


@section("An accuracy in place of a grid: true errors")
def accuracy():
    cases = "quartic linear harmonic morse double-well pendulum pendulum-separatrix double-well-barrier power-20 tanh-wall"
    rows = []
    for case in cases.split():
        # The same world-line in 32 digits and 200 windows of 24 nodes: nothing that is printed here is its error.
        with run(case, "scheme.sbp=GLL24 scheme.form=weak grid.n_gamma=24 grid.windows=200 solver.digits=32") as one:
            exact = {key: one.number(key) for key in ("t_final", "x_final")}
        cells = []
        for asked in ("1e-4", "1e-7", "1e-10", "1e-13"):
            with run(case, f"solver.accuracy={asked}", ends=(0, 3)) as one:
                if one.code != 0:
                    cells.append("not reached")
                    continue
                at_end = [abs(one.number(key) - value) for key, value in exact.items()]
                cells.append(f"{short(max(at_end))} ({short(one.summary.get('error_estimate'))})")
        rows.append([case, *cells])
    what = "Errors of t and x at the end against a run of 200 windows of 24 nodes in 32 digits; in parentheses the run's own\n"
    what += "estimate, which is for all nodes.\n"
    return what + "\n" + code("geodesic-ivp run cases/quartic.toml --set solver.accuracy=1e-10") + "\n" + table(
        ["asked for", "1e-4", "1e-7", "1e-10", "1e-13"], rows
    )


def charted(case, lengths, picture, python):
    """A chart of speed against accuracy as a table, with its picture in docs/."""
    arguments = [case_file(case), "--plot", *(["--gamma-f", lengths] if lengths else [])]
    with Results("work-precision", *arguments) as chart:
        text = code(chart.line) + "\n"
        if python:
            script = ["uv", "run", str(ROOT / "scripts/work-precision.py"), *arguments[:1], *arguments[2:]]
            subprocess.run([*script, "--out", chart.folder, "--program", PROGRAM], cwd=ROOT, check=True)
            chart.summary = json.loads((chart.folder / "summary.json").read_text())
        last = len(lengths.split(",")) if lengths else 1
        shutil.copy(chart.folder / ("error_time.svg" if last == 1 else f"error_time_{last}.svg"), DOCS / picture)
        for length in dict.fromkeys(ratio["gamma_f"] for ratio in chart.summary["ratios"]):
            rows = []
            for ratio in chart.summary["ratios"]:
                if ratio["gamma_f"] != length:
                    continue
                leader = lambda one: "" if one is None else f"{one['method']} {one['setting']}, {duration(one['seconds'])}"
                times = lambda number: "" if number is None else f"{number:.2f}"
                leaders = [leader(ratio.get(key)) for key in ("own", "own_certified", "other")]
                rows.append([short(ratio["error"], 0), *leaders, times(ratio["ratio"]), times(ratio["ratio_certified"])])
            text += f"γ_f − γ_i = {length:.6g}:\n\n"
            text += table(["error", "own", "own, certified", "others", "others/own", "others/certified"], rows) + "\n"
        return text + f"![Error against time, {case}]({picture})\n"


@section("Speed against accuracy: quartic case")
def work_precision_quartic(python=False):
    return charted("quartic", "1,1000", "work-precision-quartic.svg", python)


@section("Speed against accuracy: a steep wall")
def work_precision_tanh_wall(python=False):
    return charted("tanh-wall", None, "work-precision-tanh-wall.svg", python)


STATUS = "method form n_gamma status delta_k_max delta_q_t_max error_x_max sawtooth".split()


@section("Where methods hold and fail: quartic case")
def stability():
    with Results("stability", "cases/quartic.toml", "--plot") as atlas:
        shutil.copy(atlas.folder / "map.svg", DOCS / "stability-quartic.svg")
        shutil.copy(atlas.folder / "map_others.svg", DOCS / "stability-quartic-others.svg")
        text = code(atlas.line) + "\n```text\n"
        text += "".join(line + "\n" for line in atlas.output.splitlines() if "written" not in line) + "```\n\n"
        onsets = [one for one in atlas.summary["sawtooth"] if one["method"] == "SBP21 strong"]
        onsets.sort(key=lambda one: one["delta_gamma_omega"])
        if onsets:
            rows = [[f"{one['delta_gamma_omega']:.3g}", f"{one['gamma']:.3g}"] for one in onsets]
            text += "Where SBP21's sawtooth begins on the longest of these world-lines:\n\n" + table(["Δγω", "γ"], rows) + "\n"
    with Results("stability", "cases/quartic.toml", "--gamma-f", "100", "--delta-gamma", "0.05") as cells:
        rows = [
            [row["method"], row["form"], row["n_gamma"], row["status"], *(short(row[key]) for key in STATUS[4:])]
            for row in cells.rows("stability.csv")
        ]
        text += code(cells.line) + "\n"
        text += table(["method", "form", "N", "status", "max \\|ΔK\\|", "max \\|ΔQ_t\\|", "error of x", "sawtooth"], rows) + "\n"
    pictures = ("stability-quartic", "this program"), ("stability-quartic-others", "other methods")
    return text + "\n".join(f"![Where methods hold and fail, {name}]({file}.svg)" for file, name in pictures) + "\n"


@section("The charge at the last node of the strong form, Δγ = 1/16")
def last_node():
    lengths = "4,8,16,32"
    methods = ["--methods", "SBP21 strong,SBP42 strong", "--gamma-f", lengths, "--delta-gamma", "0.0625"]
    with Results("stability", "cases/quartic.toml", *methods) as atlas:
        rows = []
        for one in atlas.summary["last_node"]:
            numbers = {key: value for key, value in one.items() if isinstance(value, (int, float))}
            rows.append([one["method"], *(f"{value:.3g}" for value in numbers.values())])
        return code(atlas.line) + "\n" + table(["", *numbers], rows)


@section("Without the regularisation")
def unregularised():
    rows = []
    for sbp in ("SBP21", "SBP42"):
        with run("linear", f"scheme.sbp={sbp}") as right, run("linear-unregularised", f"scheme.sbp={sbp}") as wrong:
            rows.append([sbp, f"{right.number('t_final'):.4f}", f"{wrong.number('t_final'):.4f}"])
            line = wrong.line
    return code(line) + "\n" + table(["linear case", "t_N", "t_N without the regularisation"], rows)


@section("Costs: quartic case")
def costs():
    rows = []
    for name, changes in (
        ("SBP21", ""),
        ("SBP42", "scheme.sbp=SBP42"),
        ("SBP42 weak", "scheme.sbp=SBP42 scheme.form=weak"),
    ):
        times = []
        for n in (100_000, 1_000_000):
            best = []
            for _ in range(3):
                with run("quartic", f"{changes} grid.n_gamma={n}") as one:
                    best.append(one.number("solve_seconds"))
            times.append(min(best))
        rows.append([f"`run`, {name}: solve with certificate", *map(duration, times), f"{times[1] / times[0]:.1f}"])
    for sbp in ("SBP21", "SBP42"):
        times = []
        for n in (2000, 20_000):
            with run("quartic", f"scheme.sbp={sbp} solver.system=doubled grid.n_gamma={n}") as one:
                times.append(one.number("solve_seconds"))
        rows.append([f"doubled, {sbp}: 2 000 and 20 000 nodes", *map(duration, times), f"{times[1] / times[0]:.1f}"])
    return table(["", "10⁵ nodes", "10⁶ nodes", "ratio"], rows)


def heading():
    def first(command):
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()

    try:
        info = Path("/proc/cpuinfo").read_text()
        machine = re.search(r"model name\s*: (.*)", info)[1] + f", {info.count('processor')} cores"
    except (OSError, TypeError):
        machine = platform.processor() or platform.machine()
    commit = first(["git", "describe", "--always", "--dirty"])
    return f"{datetime.date.today()}, commit {commit}, {machine}, {platform.system()}"


INTRODUCTION = """# Measured

Every number and table here, and every picture in this folder, comes from `scripts/measure.py`; do not edit it by hand.
`scripts/measure.py SECTION` measures a section again, `--list` names them. Times are those of the machine and the minutes that
each section names, often a shared one: trust ratios, and absolute times within tens of per cent.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", metavar="SECTION", nargs="*", help="what to measure (default: everything)")
    parser.add_argument("--python", action="store_true", help="heyoka and SciPy in the charts of speed against accuracy")
    parser.add_argument("--list", action="store_true", help="name the sections")
    arguments = parser.parse_args()
    if arguments.list:
        return print("\n".join(f"{name:26} {title}" for name, (title, _) in SECTIONS.items()))
    if unknown := [name for name in arguments.sections if name not in SECTIONS]:
        sys.exit(f"no section is called {', '.join(unknown)}: there are {', '.join(SECTIONS)}")
    subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
    page = PAGE.read_text() if PAGE.exists() else ""
    texts = {name: text for name, text in re.findall(r"<!-- begin (\S+) -->\n(.*?)<!-- end \1 -->", page, re.S)}
    for name in arguments.sections or SECTIONS:
        title, make = SECTIONS[name]
        print(name, file=sys.stderr)
        chart = {"python": arguments.python} if name.startswith("work-precision") else {}
        texts[name] = f"## {title}\n\n*{heading()}*\n\n{make(**chart)}"
        known = [f"<!-- begin {name} -->\n{texts[name]}<!-- end {name} -->\n" for name in SECTIONS if name in texts]
        PAGE.write_text(INTRODUCTION + "\n" + "\n".join(known))


if __name__ == "__main__":
    main()
