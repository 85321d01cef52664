"""Speed against accuracy, what a promise costs, where methods hold, and whether verdicts are right."""

import collections
import math
import re
import shutil
import subprocess
import textwrap

from .page import DOCS, ROOT, Results, chosen, duration, quoted, section, short, table

ERRORS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
FLAT = 'potential={coordinates=["x","y"],formula="-1/sqrt(x^2 + y^2)"}'
# Scenes with what is told of them: their names, cases, lengths, changes, and pictures in docs/.
RACES = [
    ("quartic, 1", "quartic", "1", (), None),
    ("quartic, 1000", "quartic", "1000", (), "work-precision-quartic"),
    ("steep wall", "tanh-wall", None, (), "work-precision-tanh-wall"),
    ("star, 100", "henon-heiles", "100", (), None),
    ("star, 1000", "henon-heiles", "1000", (), "work-precision-henon-heiles"),
    ("black hole", "schwarzschild-orbit", None, (), "work-precision-schwarzschild"),
    ("rotating hole", "kerr-inclined", None, (), "work-precision-kerr"),
    ("crossed fields", "crossed-fields", "20", (), None),
    ("ellipse, e = 0.9", "kepler-eccentric", "60", ("--set", FLAT), None),
    ("Levi-Civita's", "kepler-levi-civita", "60", (), None),
]


def raced(*arguments):
    """`work-precision` with heyoka and SciPy beside it."""
    chart = Results("work-precision", *arguments, "--methods", "accuracy")
    script = ["uv", "run", "scripts/work-precision.py", *arguments]
    chart.line = " ".join(map(quoted, script))
    subprocess.run([*script, "--out", chart.folder, "--program", chosen.program], cwd=ROOT, check=True)
    chart.reread()
    return chart


def fastest(rows, error):
    """The least time of (time, error) among those with no larger error."""
    return min((time for time, found in rows if found <= error), default=None)


def judged(chart):
    """(time, error) of this program's promised runs, and of heyoka run twice: its finer run is the result then."""
    found = {"accuracy": [], "heyoka×2": []}
    for row in chart.rows("work_precision.csv"):
        method = row["method"].split(" ")[0]
        if method in found and row["status"] == "converged":
            error = max(float(row[key]) for key in row if key.startswith("error_"))
            found[method].append((float(row["seconds_min"]), error))
    return found.values()


def led(ratio):
    """The fastest of all methods, and by what it is faster than the fastest of the other side."""
    lead = ratio["ratio"]
    if not lead:
        return "–"
    winner = ratio["own"] if lead > 1 else ratio["other"]
    return f"{winner['method']} {max(lead, 1 / lead):.2f}"


WINS = "A cell is the fastest of all methods whose error is below the bound, and how many times faster it is than "
WINS += "the fastest of the other side. GLL and SBP with a number, *tolerance* and *accuracy* are this program's, all "
WINS += "others are not. A *march* is that of the library through windows of one length, without certificate and tables, "
WINS += "and *heyoka 1e3* has one more variable, a constant of that size, which makes its steps longer. Links lead to "
WINS += "charts."
TWICE = "What a result costs whose error one knows: the time of the fastest other method over that of the certified "
TWICE += "`solve`, and behind it that of heyoka run twice, then with a hundredth of the tolerance, over that "
TWICE += "of `accuracy`, which judges itself in this way. Above 1 this program is faster."


@section("Speed against accuracy")
def speed():
    rows, pairs, line = [], [], ""
    for name, case, length, changes, picture in RACES:
        with raced(case, *(["--gamma-f", length] if length else []), *changes) as chart:
            line = line or chart.line
            ratios = {float(one["error"]): one for one in chart.summary["ratios"]}
            at = [ratios[min(ratios, key=lambda known: abs(math.log(known / error)))] for error in ERRORS]
            shown = f"[{name}]({picture}.svg)" if picture else name
            rows.append([shown, *map(led, at)])
            own, twice = judged(chart)
            times = [(fastest(own, error), fastest(twice, error)) for error in ERRORS]
            both = zip((one["ratio_certified"] for one in at), (b / a if a and b else None for a, b in times))
            pairs.append([name, *(", ".join(f"{ratio:.2f}" if ratio else "–" for ratio in of) for of in both)])
            if picture:
                shutil.copy(chart.folder / "error_time.svg", DOCS / f"{picture}.svg")
                if case == "quartic":
                    shutil.copy(chart.folder / "drift_k.svg", DOCS / "drift-quartic.svg")
    head = ["error below", *(short(error, 0) for error in ERRORS)]
    text = textwrap.fill(f"`{line}` and the like. {WINS}", 120) + "\n\n" + table(head, rows)
    text += f"\n{textwrap.fill(TWICE, 120)}\n\n" + table(head, pairs)
    return text + "\n![K along a thousand units of the quartic](drift-quartic.svg)\n"


@section("What a promise costs")
def promise():
    line = "cargo bench --bench engine"
    done = subprocess.run([*line.split(), "--quiet"], cwd=ROOT, capture_output=True, text=True, check=True)
    times, accuracies = {}, ("1e-4", "1e-6", "1e-9", "1e-12")
    for name, accuracy, mode, time in re.findall(r"^(\S+) +(\S+) (\w+) +([\d.]+) us", done.stdout, re.M):
        times.setdefault(name, {})[accuracy, mode] = float(time)
    rows = []
    for name, of in times.items():
        cells = []
        for accuracy in accuracies:
            found = [of.get((accuracy, mode)) for mode in ("local", "estimated", "promised", "everything")]
            ratios = [f"{time / found[0]:.2f}" if time else "–" for time in found[1:]]
            cells.append(f"{duration(1e-6 * found[0])}: {' / '.join(ratios)}")
        rows.append([name, *cells])
    text = f"`{line}`: the time with a tolerance and nothing more, and in units of it that with the error estimate /\n"
    text += "with the promise / with the certificate and all nodes stored. Windows have 16 nodes; – is refused.\n\n"
    return text + table(["", *accuracies], rows)


HELD = "SBP21 strong,SBP42 strong,SBP42 weak,SBP84 weak,GLL8 weak,GLL16 weak,accuracy,tolerance"
STATUSES = "accurate inaccurate sawtooth drifting diverged".split()


@section("Where methods hold and fail, quartic case")
def stability():
    with Results("stability", "quartic", "--plot") as atlas:
        for name in ("", "-others"):
            shutil.copy(atlas.folder / f"map{name.replace('-', '_')}.svg", DOCS / f"stability-quartic{name}.svg")
        counts = collections.defaultdict(collections.Counter)
        for row in atlas.rows("stability.csv"):
            name = re.sub(r" tol=.*", "", row["method"])
            name += f" {row['form']}" if name.startswith(("SBP", "GLL")) else ""
            counts[name][row["status"]] += 1
    rows = []
    for name in HELD.split(","):
        of = counts[name]
        rows.append([name, *(of[status] for status in STATUSES), sum(of.values()) - sum(of[s] for s in STATUSES)])
    text = f"`{atlas.line}`: cells of the map by what became of the run.\n\n"
    text += table(["", *STATUSES, "no solution"], rows)
    return text + "\n![Where the schemes of this program hold and fail](stability-quartic.svg)\n"


@section("The charge at the last node of the strong form, Δγ = 1/16")
def last_node():
    lengths = "4,8,16,32"
    methods = ["--methods", "SBP21 strong,SBP42 strong", "--gamma-f", lengths, "--delta-gamma", "0.0625"]
    with Results("stability", "quartic", *methods) as atlas:
        found = {(one["method"], one["gamma_f"]): f"{one['delta_q_t_last']:.3g}" for one in atlas.summary["last_node"]}
    names = dict.fromkeys(name for name, _ in found)
    rows = [[name, *(found[name, float(length)] for length in lengths.split(","))] for name in names]
    return f"`{atlas.line}`\n\n" + table(["ΔQ_t at γ_f =", *lengths.split(",")], rows)


@section("The verdict on random scenes")
def verdict():
    line = "cargo bench --bench verdict -- 2000 1"
    # It ends with 1 if a trusted result is wrong, and the table says so too.
    done = subprocess.run(line.split(), cwd=ROOT, stdout=subprocess.PIPE, text=True)
    return f"`{line}`\n\n" + done.stdout[done.stdout.index("| verdict |") : done.stdout.index("\n| scheme, scene")]
