"""Pictures in docs/ and their tables: speed against accuracy, and where methods hold."""

import json
import math
import shlex
import shutil
import subprocess
import sys

from .page import DOCS, PROGRAM, ROOT, Results, code, duration, section, short, table


def leader(one):
    return "" if one is None else f"{one['method']} {one['setting']}, {duration(one['seconds'])}"


def times(number):
    return "" if number is None else f"{number:.2f}"


def charted(case, lengths, picture, python, drift=None):
    """A chart of speed against accuracy as a table, with its pictures in docs/, if there is to be one."""
    arguments = [case, "--plot", *(["--gamma-f", lengths] if lengths else [])]
    with Results("work-precision", *arguments) as chart:
        text = code(chart.line) + "\n"
        if python:
            file = next((ROOT / "cases").rglob(f"{case}.toml"))
            script = ["uv", "run", str(ROOT / "scripts/work-precision.py"), str(file), *arguments[2:]]
            line = ["uv run scripts/work-precision.py", str(file.relative_to(ROOT)), *arguments[2:]]
            text = code(" ".join(line)) + "\n"
            subprocess.run([*script, "--out", chart.folder, "--program", PROGRAM], cwd=ROOT, check=True)
            chart.summary = json.loads((chart.folder / "summary.json").read_text())
        last = len(lengths.split(",")) if lengths else 1
        pictures = []
        if picture:
            shutil.copy(chart.folder / ("error_time.svg" if last == 1 else f"error_time_{last}.svg"), DOCS / picture)
            pictures.append(f"![Error against time, {case}]({picture})\n")
        if drift:
            shutil.copy(chart.folder / "drift_k.svg", DOCS / drift)
            pictures.append(f"![K along the run, {case}]({drift})\n")
        for length in dict.fromkeys(ratio["gamma_f"] for ratio in chart.summary["ratios"]):
            rows = []
            for ratio in chart.summary["ratios"]:
                if ratio["gamma_f"] != length:
                    continue
                leaders = [leader(ratio.get(key)) for key in ("own", "own_certified", "other")]
                ratios = [times(ratio[key]) for key in ("ratio", "ratio_certified")]
                rows.append([short(ratio["error"], 0), *leaders, *ratios])
            text += f"γ_f − γ_i = {length:.6g}:\n\n"
            text += table(["error", "own", "own, certified", "others", "others/own", "others/certified"], rows) + "\n"
        return text + "\n".join(pictures)


@section("Speed against accuracy: quartic case")
def work_precision_quartic(python=False):
    return charted("quartic", "1,1000", "work-precision-quartic.svg", python, "drift-quartic.svg")


@section("Speed against accuracy: a steep wall")
def work_precision_tanh_wall(python=False):
    return charted("tanh-wall", None, "work-precision-tanh-wall.svg", python)


# Methods that choose their steps by a tolerance, and those whose steps are picked by hand.
ADAPTIVE = ("DOP853", "Radau5", "Taylor", "heyoka")
CASES = {"quartic": "quartic", "double-well": "double well", "morse": "Morse"}
CASES |= {"pendulum-separatrix": "separatrix", "tanh-wall": "steep wall"}


def cell(rows, error):
    """Times of the fastest methods whose errors are below the bound, over that of `accuracy`."""
    best = {}
    for row in rows:
        errors = [float(value) for key, value in row.items() if key.startswith("error_") and value]
        if row["status"] != "converged" or max(errors) > error:
            continue
        method = row["method"]
        kind = "adaptive" if method.startswith(ADAPTIVE) else "other"
        kind = method if method == "accuracy" else "own" if method.startswith(("SBP", "GLL")) else kind
        best[kind] = min(float(row["seconds_min"]), best.get(kind, math.inf))
    own = best.get("accuracy")
    return " / ".join(f"{best[kind] / own:.2f}" if own and kind in best else "–" for kind in ("adaptive", "other"))


@section("Speed against accuracy: accuracies in five potentials")
def work_precision_five_potentials(python=False):
    beside = "with heyoka" if python else "without heyoka"
    text = f"Times over that of `accuracy`: of the fastest adaptive method ({beside}) / of the fastest with steps "
    text += "picked by hand.\n\n"
    for length in ("1", "100", "1000"):
        columns = {}
        for case in CASES:
            # Steps picked by hand may take long on long runs, and are not the fastest then.
            arguments = [case, "--gamma-f", length, "--longest", "0.03"]
            # The script runs the program again.
            with Results("work-precision", *arguments, *(["--methods", "accuracy"] if python else [])) as chart:
                if python:
                    file = next((ROOT / "cases").rglob(f"{case}.toml"))
                    script = ["uv", "run", str(ROOT / "scripts/work-precision.py"), str(file), *arguments[1:]]
                    subprocess.run([*script, "--out", chart.folder, "--program", PROGRAM], cwd=ROOT, check=True)
                columns[case] = chart.rows("work_precision.csv")
        rows = [[f"1e-{k}", *(cell(columns[case], 10.0**-k) for case in CASES)] for k in range(3, 13)]
        text += f"γ_f − γ_i = {length}:\n\n" + table(["error", *CASES.values()], rows) + "\n"
    return text.rstrip() + "\n"


@section("Speed against accuracy: a star in a galaxy")
def work_precision_henon_heiles(python=False):
    return charted("henon-heiles", "100,1000", "work-precision-henon-heiles.svg", python)


@section("Speed against accuracy: an orbit around a black hole")
def work_precision_schwarzschild(python=False):
    return charted("schwarzschild-orbit", None, "work-precision-schwarzschild.svg", python)


@section("Speed against accuracy: an inclined orbit around a rotating black hole")
def work_precision_kerr(python=False):
    return charted("kerr-inclined", None, "work-precision-kerr.svg", python)


@section("Speed against accuracy: a charge in crossed fields")
def work_precision_crossed_fields(python=False):
    return charted("crossed-fields", "20", None, python)


@section("Speed against accuracy: a planet on an eccentric ellipse", needs_python=True)
def kepler():
    line = "uv run scripts/kepler.py"
    print(f"  {line}", file=sys.stderr)
    run = [*line.split(), "--program", PROGRAM, "--json"]
    rows = json.loads(subprocess.run(run, cwd=ROOT, capture_output=True, text=True, check=True).stdout)
    time = lambda seconds: "" if seconds is None else duration(seconds)
    cells = [[short(error, 0), *map(time, times)] for error, *times in (row.values() for row in rows)]
    return code(line) + "\n" + table(rows[0], cells)


@section("Iterations of a window: sweeps and Newton's method", needs_python=True)
def newton():
    line = "uv run scripts/newton.py"
    print(f"  {line}", file=sys.stderr)
    run = [*line.split(), "--json"]
    rows = json.loads(subprocess.run(run, cwd=ROOT, capture_output=True, text=True, check=True).stdout)
    cells = [[row.pop("motion"), row.pop("windows"), *(f"{value:.2g}" for value in row.values())] for row in rows]
    head = ["motion", "windows", "largest tail", "sweeps", "simplified Newton", "Newton"]
    return code(line) + "\n" + table(head, cells)


def bench(line):
    """What a bench prints."""
    print(f"  {line}", file=sys.stderr)
    done = subprocess.run([*shlex.split(line), "--quiet"], cwd=ROOT, capture_output=True, text=True, check=True)
    return code(line) + "\n```text\n" + done.stdout + "```\n"


@section("What a promise costs")
def costs_of_promises():
    return bench("cargo bench --bench engine")


STATUS = "method form n_gamma status delta_k_max delta_q_t_max error_x_max sawtooth".split()


@section("Where methods hold and fail: quartic case")
def stability():
    with Results("stability", "quartic", "--plot") as atlas:
        shutil.copy(atlas.folder / "map.svg", DOCS / "stability-quartic.svg")
        shutil.copy(atlas.folder / "map_others.svg", DOCS / "stability-quartic-others.svg")
        text = code(atlas.line) + "\n```text\n"
        text += "".join(line + "\n" for line in atlas.output.splitlines() if "written" not in line) + "```\n\n"
        onsets = [one for one in atlas.summary["sawtooth"] if one["method"] == "SBP21 strong"]
        onsets.sort(key=lambda one: one["delta_gamma_omega"])
        if onsets:
            rows = [[f"{one['delta_gamma_omega']:.3g}", f"{one['gamma']:.3g}"] for one in onsets]
            text += "Where SBP21's sawtooth begins on the longest of these world-lines:\n\n"
            text += table(["Δγω", "γ"], rows) + "\n"
    with Results("stability", "quartic", "--gamma-f", "100", "--delta-gamma", "0.05") as cells:
        rows = [
            [row["method"], row["form"], row["n_gamma"], row["status"], *(short(row[key]) for key in STATUS[4:])]
            for row in cells.rows("stability.csv")
        ]
        text += code(cells.line) + "\n"
        head = ["method", "form", "N", "status", "max \\|ΔK\\|", "max \\|ΔQ_t\\|", "error of x", "sawtooth"]
        text += table(head, rows) + "\n"
    pictures = ("stability-quartic", "this program"), ("stability-quartic-others", "other methods")
    return text + "\n".join(f"![Where methods hold and fail, {name}]({file}.svg)" for file, name in pictures) + "\n"


@section("The charge at the last node of the strong form, Δγ = 1/16")
def last_node():
    lengths = "4,8,16,32"
    methods = ["--methods", "SBP21 strong,SBP42 strong", "--gamma-f", lengths, "--delta-gamma", "0.0625"]
    with Results("stability", "quartic", *methods) as atlas:
        rows = []
        for one in atlas.summary["last_node"]:
            numbers = {key: value for key, value in one.items() if isinstance(value, (int, float))}
            rows.append([one["method"], *(f"{value:.3g}" for value in numbers.values())])
        return code(atlas.line) + "\n" + table(["", *numbers], rows)


@section("The verdict on random scenes")
def verdict():
    line = "cargo bench --bench verdict -- 2000 1"
    # It ends with 1 if a trusted result is wrong, and the table says so too.
    done = subprocess.run(line.split(), cwd=ROOT, stdout=subprocess.PIPE, text=True)
    return code(line) + "\n" + done.stdout[done.stdout.index("| verdict |") :]
