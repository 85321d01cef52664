#!/usr/bin/env python3
"""Compares two folders of results that scripts/golden.sh has written.

Usage: golden.py [--exact] OLD NEW

Names, headers, keys, exit codes and words must be the same. Numbers may differ by rounding: by a unit times the size
of the quantity that they are or deviate from. The unit is 1e-13, in doubled runs N^2 1e-15 with N nodes of a window,
with more digits 10^(3 - digits), in studies 1e-11, and in a run to an accuracy this accuracy. Where the old run itself
is farther from the truth, three times this distance is allowed. With --exact only times may differ.
"""

import csv
import json
import re
import sys
from collections import defaultdict
from decimal import Decimal, getcontext
from pathlib import Path

getcontext().prec = 90
SHOWN = 3  # This many differences of a kind are shown.

# The first pattern that is found in the name of a column or key says which quantity gives the size of its numbers;
# `Sizes` takes the quantities from the files of the old run. BOUNDED numbers depend on rounding or may improve, so they
# must only not be more than twice what they were. SLOPES are fits, which magnify rounding. Any other number is measured
# by itself.
BOUNDED, DIGITS, SLOPES = "bounded", "digits", "slopes"
QUANTITIES = [
    (r"iterations|evaluations|gradient_norm|error|residual|unproved|work_defect|plateau|^points$", BOUNDED),
    (r"good_digits", DIGITS),
    (r"slope", SLOPES),
    (r"delta_(k|energy)(_|$)|^k$|^energy$", "action"),  # This is the sum of abs(p q_dot), of which K and E are parts.
    (r"h_bvp", "h_bvp"),
    (r"delta_q_|^charges|^q_t$|p_final|multipliers|conserved_sums|^work", "momentum"),
    (r"delta_g_", "force"),  # This is a derivative of momenta, so that their rounding is divided by the step in gamma.
    (r"_dot(_final)?(\.|$)", "velocity"),
    (r"delta_|^invariants", "invariant"),
    (r"^gamma(_final)?$", "gamma"),
    (r"_final$|^final\.|^point\.|^eps_|sawtooth|branch_distance", "coordinate"),
]
GRID_TABLES = {"trajectory.csv", "residuals.csv", "branches.csv"}

differences = defaultdict(list)


def differ(kind, where, what=""):
    differences[kind].append(f"{where}{': ' if what else ''}{what}")


def number(text):
    try:
        return Decimal(text) if not isinstance(text, bool) else None
    except (ArithmeticError, TypeError, ValueError):
        return None


def table(text):
    rows = list(csv.reader(text.splitlines()))
    return rows if rows and rows[0] and rows[0][0] in {"gamma", "event", "row", "sbp", "method"} else None


def document(text):
    """Reads JSON into its leaves with dotted names. Of the history of an iteration only the length counts."""
    def leaves(value, name):
        if name == "history":
            return [("history.iterations", Decimal(len(value)))]
        if not isinstance(value, (dict, list)) or not value:
            return [(name, value)]
        items = value.items() if isinstance(value, dict) else enumerate(value)
        return [leaf for key, part in items for leaf in leaves(part, f"{name}.{key}" if name else str(key))]

    try:
        return dict(leaves(json.loads(text, parse_float=Decimal, parse_int=Decimal), "")) if text[:1] == "{" else None
    except ValueError:
        return None


def read(path):
    """Reads a file without its times."""
    text = path.read_text(errors="replace")
    text = re.sub(r'(seconds": )[\d.e-]+|, [\d.e-]+ (ms|s|µs)$', r"\1null", text, flags=re.MULTILINE)
    rows = table(text) if "seconds" in text else None
    times = [i for i, name in enumerate(rows[0]) if "seconds" in name] if rows else []
    for row in rows[1:] if times else []:
        row[:] = ["" if i in times else cell for i, cell in enumerate(row)]
    return "\n".join(map(",".join, rows)) if times else text


class Sizes:
    """The sizes of the quantities of an old run, and how far rounding may move them."""

    def __init__(self, command, texts, truths):
        summary = next((d for d in map(document, texts.values()) if d and "status" in d), {})
        tables = {name: rows for name, rows in ((name, table(text)) for name, text in texts.items()) if rows}
        settings = {**dict(re.findall(r"(digits|system)=([\w-]+)", command)), **summary}
        accuracies = re.findall(r"[\d.e+-]+", ",".join(re.findall(r"accuracy=([\d.e,+-]+)", command)))
        self.accuracy = float(summary.get("accuracy") or max(map(Decimal, accuracies), default=0))
        self.digits, self.study = int(settings.get("digits", 16)), re.search("g (converge|stability)", command)
        self.unit = 1e-13 if self.digits == 16 else 10.0 ** (3 - self.digits)
        if settings.get("system") == "doubled":
            self.unit = max(self.unit, int(settings.get("n_gamma", 128)) ** 2 * 10.0 ** (1 - self.digits))
        if self.study:
            self.unit *= 100
        self.unit = max(self.unit, self.accuracy)

        values, steps = defaultdict(float), []
        for rows in tables.values():
            for name, *cells in zip(*rows):
                values[name] = max([values[name], *(abs(float(x)) for x in cells if number(x) is not None)])
            if rows[0][0] == "gamma":
                steps += [abs(float(b[0]) - float(a[0])) for a, b in zip(rows[1:], rows[2:]) if a[0] != b[0]]
        values.update({key: abs(float(value)) for key, value in summary.items() if isinstance(value, Decimal)})
        self.names = [value for key, value in summary.items() if key.startswith("coordinates.")]
        self.names = self.names or sorted(q for q in values if f"{q}_dot" in values) or ["t", "x"]

        def largest(*patterns):
            return {q: max(values.get(pattern.replace("?", q), 0.0) for pattern in patterns) for q in self.names}

        momentum, velocity = largest("p_final.?", "charges.?", "q_?"), largest("?_dot", "?_dot_final", "q_dot_final.?")
        if "p_final.x" not in values and "x" in momentum:
            momentum["x"] = velocity["x"]
        if not any(momentum.values()):
            momentum = dict(velocity)
        action = max([sum(momentum[q] * velocity[q] for q in self.names), values["k"], values["energy"]])
        self.of = {
            "coordinate": largest("?", "?_1", "?_2", "?_final", "final.?", "reference.?_size"),
            "velocity": velocity,
            "momentum": momentum,
            "action": {"": action},
            "force": {"": max([*momentum.values(), *velocity.values()]) / min(steps, default=1.0)},
            "gamma": {"": max(values["gamma"], values["gamma_final"])},
            "h_bvp": {"": values["h_bvp_bound"]},
            "invariant": {key[11:]: size for key, size in values.items() if key.startswith("invariants.")},
        }
        # A quantity that vanishes is measured by the largest one of its kind.
        for sizes in self.of.values():
            most = max(sizes.values(), default=0.0) or 1.0
            sizes.update({key: most if size <= 1e-8 * most else size for key, size in sizes.items()})
            sizes.setdefault("", most)
        if self.accuracy:
            self.of["coordinate"] = {key: max(1.0, size) for key, size in self.of["coordinate"].items()}
        # Charges and the equations of motion are exact but for rounding, so they show the rounding of the old run.
        charges = largest("max_abs_delta_q_?_corrected", "max_abs_delta_q_corrected.?")
        self.rounding = max(charges[q] / momentum[q] for q in self.names)
        self.force = values["max_abs_delta_g_interior"]
        # A run of the same case on the same grid in 40 digits is the truth for one in 16.
        self.distance = defaultdict(float)
        for name, rows in tables.items() if self.digits == 16 and not self.accuracy else ():
            true = table(truths.get(name, "")) or []
            same = len(rows) == len(true) and all(abs(float(a[0]) - float(b[0])) < 1e-9 * self.of["gamma"][""]
                                                  for a, b in zip(rows[1:], true[1:]) if rows[0][0] == "gamma")
            for column, exact in zip(zip(*rows), zip(*true)) if same and rows[0] == true[0] else ():
                pairs = ((number(a), number(b)) for a, b in zip(column[1:], exact[1:]))
                self.distance[column[0]] = max(float(abs(a - b)) for a, b in pairs if a is not None and b is not None)

    def tolerance(self, quantity, name, old):
        sizes = self.of.get(quantity, {"": old or 1.0})
        key = next((q for q in sizes if q and re.search(rf"(^|[_.]){re.escape(q)}([_.]|$)", name)), "")
        column = {"coordinate": key, "velocity": f"{key}_dot"}.get(quantity, re.sub("^max_abs_|_ends$", "", name))
        rounding = {"coordinate": 0.0, "gamma": 0.0, "force": self.force}.get(quantity, self.rounding * sizes[key])
        # Velocities and what follows from them are not held to the accuracy that coordinates are held to.
        unit = self.unit * (100 if self.accuracy and quantity != "coordinate" else 1)
        return max(unit * sizes[key], 3 * rounding, 3 * self.distance[column], 1e-6 * old if self.study else 0.0)

    def excess(self, name, old, new):
        """Gives the distance of two numbers as a multiple of what is allowed."""
        quantity = next((kind for pattern, kind in QUANTITIES if re.search(pattern, name)), None)
        if quantity is None and re.sub("_[12]$", "", name) in self.names:
            quantity = "coordinate"
        if quantity == BOUNDED or self.accuracy and name in {"n_gamma", "windows"}:
            # An error is the distance of two results, so it may also move as they may.
            rounding = self.tolerance("coordinate", name, 0.0) if "error" in name else self.unit / 100
            return abs(float(new)) / (2 * abs(float(old)) + rounding)
        if quantity == DIGITS:
            return float(old - new) / 1.5
        if quantity == SLOPES:
            return float(abs(new - old)) / 1e-2
        return float(abs(new - old)) / self.tolerance(quantity, name, abs(float(old)))


def compare_values(sizes, where, values):
    """Compares named pairs of values. Of each name it reports where its numbers differ most."""
    worst = {}
    for name, place, old, new in values:
        a, b = number(old), number(new)
        if old != new and (a is None or b is None):
            compare_words(f"{where} {name}{place}", str(old), str(new))
        elif a is not None and a != b and sizes.excess(name, a, b) > worst.get(name, (1.0,))[0]:
            worst[name] = (sizes.excess(name, a, b), place, old, new)
    for name, (excess, place, old, new) in worst.items():
        kind = f"Numbers of {re.sub('[.][0-9]+', '', name)} in {Path(where).name} moved by more than is allowed"
        differ(kind, where, f"{name}{place} was {old} and is {new}, {excess:.3g} times what is allowed")


def compare_tables(sizes, where, old, new):
    if old[0] != new[0]:
        differ("The columns changed", where, f"they were {','.join(old[0])} and are {','.join(new[0])}")
    elif sizes.accuracy and (Path(where).name in GRID_TABLES or "delta_k" in old[0]):
        return  # The program chooses the grid of a run to an accuracy, so that rows are not comparable.
    elif len(old) != len(new):
        differ("The number of rows changed", where, f"there were {len(old) - 1} rows and there are {len(new) - 1}")
    else:
        rows = ((i, a, b) for i, (a, b) in enumerate(zip(old, new)) if a != b)
        cells = ((name, f" in row {i}", x, y) for i, a, b in rows for name, x, y in zip(old[0], a, b))
        compare_values(sizes, where, cells)


def beyond_estimate(sizes, summary):
    estimate = float(summary.get("error_estimate", "inf"))
    errors = ((q, float(summary.get(f"error_max.{q}", 0)) / sizes.of["coordinate"][q]) for q in sizes.names)
    return [f"{q} is off by {error:.3g}, more than {estimate:.3g}" for q, error in errors if error > estimate]


def compare_documents(sizes, where, old, new):
    if list(old) != list(new):
        keys = f"gone are {sorted(set(old) - set(new))}, new are {sorted(set(new) - set(old))}"
        differ("The keys changed", where, keys if set(old) != set(new) else "their order is another one")
    compare_values(sizes, where, ((key, "", old[key], new[key]) for key in old if key in new))
    if sizes.accuracy and float(new.get("error_estimate", 0)) > sizes.accuracy:
        differ("The estimate exceeds the accuracy", where, f"it is {new['error_estimate']}")
    if sizes.accuracy and not beyond_estimate(sizes, old) and beyond_estimate(sizes, new):
        differ("An error exceeds its estimate", where, "; ".join(beyond_estimate(sizes, new)))


def compare_words(where, old, new, exact=False):
    """Compares words. A number among them may be up to twice what it was, but a value after "=" must stay to 1 %."""
    numbers = r"(= )?([-+]?\d+\.?\d*(?:e[-+]?\d+)?)"
    old, new = ([re.sub(r"good to \d+|\s+", " ", line) for line in text.splitlines()] for text in (old, new))
    if len(old) != len(new):
        differ("The number of lines changed", where, f"there were {len(old)} lines and there are {len(new)}")
    for a, b in zip(old, new):
        if a != b and (exact or re.sub(numbers, "#", a) != re.sub(numbers, "#", b)):
            differ("Words changed", where, f"they were '{a}' and are '{b}'")
            break
        for (equals, x), (_, y) in zip(re.findall(numbers, a), re.findall(numbers, b)):
            x, y = float(x), float(y)
            if abs(y) > 2 * abs(x) + 1e-12 or equals and abs(x) > 1e-6 and abs(y - x) > 0.01 * abs(x):
                differ("A number among words moved", where, f"it was {x:g} and is {y:g} in '{b.strip()}'")


def compare_job(old, new, name, exact):
    """Compares the files of one job, folder by folder, and gives their number."""
    olds, news = ({f.relative_to(root): f for f in root.rglob("*") if f.is_file()} for root in (old, new))
    for file in sorted(olds.keys() ^ news.keys()):
        differ("A file is missing" if file in olds else "A file is new", f"{name}/{file}")
    command, codes = (read(old / f) if (old / f).exists() else "" for f in ("command", "exit"))
    # What a refusal or a check says does not depend on rounding.
    fixed = set(re.findall(r"\d+", codes)) <= {"1", "2"} or not re.search(r"g (run|conv|stab|merge)|--run", command)
    sizes = {}
    for file in sorted(olds.keys() & news.keys()):
        if file.suffix == ".svg" and not exact:
            if news[file].stat().st_size == 0:
                differ("A picture is empty", f"{name}/{file}")
            continue
        a, b, where = read(olds[file]), read(news[file]), f"{name}/{file}"
        if a == b:
            continue
        if file.parent not in sizes and not exact:
            texts = {f.name: read(path) for f, path in olds.items() if f.parent == file.parent and f.suffix != ".svg"}
            truths = {f: old.parent / "digits-40" / file.parent / f for f in GRID_TABLES}
            truths = {f: read(path) for f, path in truths.items() if path.exists()}
            sizes[file.parent] = Sizes(command, texts, truths)
        if exact:
            lines = zip([*a.splitlines(), "(end)"], [*b.splitlines(), "(end)"])
            x, y = next(((x, y) for x, y in lines if x != y), ("", ""))
            differ("A file changed", where, f"'{x}' is now '{y}'")
        elif file.name == "exit":
            differ("The exit code changed", where, f"it was '{a.strip()}' and is '{b.strip()}'")
        elif table(a) and table(b):
            compare_tables(sizes[file.parent], where, table(a), table(b))
        elif document(a) and document(b):
            compare_documents(sizes[file.parent], where, document(a), document(b))
        else:
            compare_words(where, a, b, exact=fixed or file.suffix == ".toml" or file.name == "command")
    return len(olds)


def main(arguments):
    old, new = (Path(argument) for argument in arguments if argument != "--exact")
    jobs, others = ({file.parent.relative_to(root) for file in root.rglob("command")} for root in (old, new))
    for name in sorted(jobs - others):
        differ("A job is missing", name)
    if not jobs:
        differ("There is nothing to compare", old)
    files = sum(compare_job(old / name, new / name, name, "--exact" in arguments) for name in sorted(jobs & others))
    for kind, places in sorted(differences.items()):
        print(f"{kind}; this is found {len(places)} times:")
        for place in places[:SHOWN]:
            print(f"    {place[:400]}")
    count = sum(map(len, differences.values()))
    print(f"{len(jobs & others)} jobs with {files} files were compared; {len(others - jobs)} new jobs were not.")
    print(f"There are {count} differences." if count else "There is no difference.")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
