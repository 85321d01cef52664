"""Pictures in docs/ and their tables: speed against accuracy, and where methods hold."""

import math
import shutil
import subprocess

from .page import DOCS, ROOT, Results, chosen, code, duration, quoted, section, short, table

# Methods that choose their steps by a tolerance, and those whose steps are picked by hand.
ADAPTIVE = ("DOP853", "Radau5", "Taylor", "heyoka")
CASES = {"quartic": "quartic", "double-well": "double well", "morse": "Morse"}
CASES |= {"pendulum-separatrix": "separatrix", "tanh-wall": "steep wall"}


def raced(*arguments):
    """`work-precision`, by the script where Python's methods are to stand beside the program's."""
    chart = Results("work-precision", *arguments, *(["--methods", "accuracy"] if chosen.python else []))
    if chosen.python:
        script = ["uv", "run", "scripts/work-precision.py", *(one for one in arguments if one != "--plot")]
        chart.line = " ".join(map(quoted, script))
        line = [*script, "--out", chart.folder, "--program", chosen.program]
        subprocess.run(line, cwd=ROOT, check=True)
        chart.reread()
    return chart


def charted(case, lengths, pictures, *more):
    """A chart of speed against accuracy as a table, with its pictures in docs/."""
    with raced(case, "--plot", *(["--gamma-f", lengths] if lengths else []), *more) as chart:
        text, ratios = code(chart.line) + "\n", chart.summary["ratios"]
        for length in dict.fromkeys(ratio["gamma_f"] for ratio in ratios):
            rows = []
            for ratio in (ratio for ratio in ratios if ratio["gamma_f"] == length):
                leaders = (ratio.get(key) for key in ("own", "own_certified", "other"))
                leaders = [one and f"{one['method']} {one['setting']}, {duration(one['seconds'])}" for one in leaders]
                times = [ratio[key] and f"{ratio[key]:.2f}" for key in ("ratio", "ratio_certified")]
                rows.append([short(ratio["error"], 0), *(cell or "" for cell in leaders + times)])
            text += f"γ_f − γ_i = {length:.6g}:\n\n"
            text += table(["error", "own", "own, certified", "others", "others/own", "others/certified"], rows) + "\n"
        last = len(lengths.split(",")) if lengths else 1
        for title, picture in pictures.items():
            name = "drift_k" if title.startswith("K") else "error_time" if last == 1 else f"error_time_{last}"
            shutil.copy(chart.folder / f"{name}.svg", DOCS / picture)
        return text + "\n".join(f"![{title}, {case}]({picture})\n" for title, picture in pictures.items())


def chart(name, title, case, lengths=None, pictures={}):
    section(f"Speed against accuracy: {title}", f"work-precision-{name}")(lambda: charted(case, lengths, pictures))


SPEED, DRIFT = "Error against time", "K along the run"
chart("quartic", "quartic case", "quartic", "1,1000",
      {SPEED: "work-precision-quartic.svg", DRIFT: "drift-quartic.svg"})
chart("tanh-wall", "a steep wall", "tanh-wall", None, {SPEED: "work-precision-tanh-wall.svg"})


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


@section("Speed against accuracy: accuracies in five potentials", "work-precision-five-potentials")
def five_potentials():
    beside = "with heyoka" if chosen.python else "without heyoka"
    text = f"Times over that of `accuracy`: of the fastest adaptive method ({beside}) / of the fastest with steps "
    text += "picked by hand.\n\n"
    for length in ("1", "100", "1000"):
        columns = []
        for case in CASES:
            # Steps picked by hand may take long on long runs, and are not the fastest then.
            with raced(case, "--gamma-f", length, "--longest", "0.03") as race:
                columns.append(race.rows("work_precision.csv"))
        rows = [[f"1e-{k}", *(cell(column, 10.0**-k) for column in columns)] for k in range(3, 13)]
        text += f"γ_f − γ_i = {length}:\n\n" + table(["error", *CASES.values()], rows) + "\n"
    return text.rstrip() + "\n"


chart("henon-heiles", "a star in a galaxy", "henon-heiles", "100,1000", {SPEED: "work-precision-henon-heiles.svg"})
chart("schwarzschild", "an orbit around a black hole", "schwarzschild-orbit", None,
      {SPEED: "work-precision-schwarzschild.svg"})
chart("kerr", "an inclined orbit around a rotating black hole", "kerr-inclined", None,
      {SPEED: "work-precision-kerr.svg"})
chart("crossed-fields", "a charge in crossed fields", "crossed-fields", "20")


@section("Speed against accuracy: a planet on an eccentric ellipse")
def kepler():
    # Nearly ten turns: with t for γ, and with the eccentric anomaly.
    turns, flat = "60", 'potential={coordinates=["x","y"],formula="-1/sqrt(x^2 + y^2)"}'
    text = charted("kepler-eccentric", turns, {}, "--set", flat) + "In Levi-Civita's coordinates:\n\n"
    return text + charted("kepler-levi-civita", turns, {})


@section("What a promise costs")
def costs_of_promises():
    line = "cargo bench --bench engine"
    done = subprocess.run([*line.split(), "--quiet"], cwd=ROOT, capture_output=True, text=True, check=True)
    return code(line) + "\n```text\n" + done.stdout + "```\n"


STATUS = "method form n_gamma status delta_k_max delta_q_t_max error_x_max sawtooth".split()


@section("Where methods hold and fail: quartic case")
def stability():
    with Results("stability", "quartic", "--plot") as atlas:
        shutil.copy(atlas.folder / "map.svg", DOCS / "stability-quartic.svg")
        shutil.copy(atlas.folder / "map_others.svg", DOCS / "stability-quartic-others.svg")
        text = atlas.text() + "\n"
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
