"""Errors, charges and costs of the schemes."""

from .page import Results, duration, run, section, short, table


# Section 4 of the paper: slopes of ε_t(γ_f) and ε_x(γ_f) against 1/N, and the numbers of nodes that fit them.
PAPER = {
    ("linear", "SBP21"): (2.07, 2.08, "16:64"),
    ("linear", "SBP42"): (3.48, 3.07, "16:64"),
    ("quartic", "SBP21"): (2.06, 2.08, "16:64"),
    ("quartic", "SBP42"): (3.13, 2.84, "64:256"),
}


@section("The paper's numbers: slopes of the errors")
def orders():
    rows = []
    for (case, sbp), (of_t, of_x, fitted) in PAPER.items():
        row = [f"{case}, {sbp}, N = {fitted.replace(':', ' … ')}"]
        with Results("converge", case, "--sbp", sbp, "--fit-range", fitted) as swept:
            slopes = {one["quantity"]: one for one in swept.rows("slopes.csv")}
            for name, paper in (("eps_t_final", of_t), ("eps_x_final", of_x), ("eps_t_l2", "–"), ("eps_x_l2", "–")):
                one = [float(slopes[name][key]) for key in ("slope_vs_inverse_n", "slope")]
                row.append(f"{paper} / {one[0]:.2f} / {one[1]:.2f}")
        rows.append(row)
    text = f"`{swept.line}`: the paper's / ours against 1/N, as the paper fits / ours against Δγ.\n\n"
    return text + table(["", "ε_t(γ_f)", "ε_x(γ_f)", "ε_t in L2", "ε_x in L2"], rows)


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
    what = "The paper's four base cases (N = 32) in both systems: the largest value of all eight.\n"
    return what + "\n" + table(["", "16 digits", "40 digits", "60 digits"], rows)


@section("Operators: orders and errors at γ_f, quartic case in 60 digits")
def operators():
    names = "SBP21,SBP42,SBP63,SBP84,GLL8,GLL16"
    sweep = ["--sbp", names, "--form", "strong,weak", "--n-gamma", "256,512,1024,2048", "--fit-range", "200:2100"]
    rows = []
    with Results("converge", "quartic", *sweep, "--set", "solver.digits=60") as swept:
        for sbp in names.split(","):
            rows.append([sbp])
            for form in ("strong", "weak"):
                at = [row for row in swept.rows("convergence.csv") if (row["sbp"], row["form"]) == (sbp, form)]
                nearest = min(at, key=lambda row: abs(int(row["n_gamma"]) - 1024))
                slopes = [row for row in swept.rows("slopes.csv") if (row["sbp"], row["form"]) == (sbp, form)]
                slopes = {row["quantity"]: f"{float(row['slope']):.2f}" for row in slopes}
                rows[-1] += [slopes["eps_x_final"], slopes["eps_t_final"], short(nearest["eps_x_final"])]
    head = [f"{what}, {form}" for form in ("strong", "weak") for what in ("slope of ε_x", "of ε_t", "ε_x at N = 1024")]
    return f"`{swept.line}`\n\n" + table(["", *head], rows)


@section("An accuracy in place of a grid: true errors")
def accuracy():
    rows = []
    for case in "quartic morse double-well pendulum-separatrix power-20 tanh-wall".split():
        # The same world-line in 32 digits and 200 windows of 24 nodes: nothing that is printed here is its error.
        with run(case, "scheme.sbp=GLL24 scheme.form=weak grid.n_gamma=24 grid.windows=200 solver.digits=32") as one:
            exact = {key: one.number(key) for key in ("t_final", "x_final")}
        cells = []
        for asked in ("1e-4", "1e-7", "1e-10", "1e-13"):
            with run(case, f"solver.accuracy={asked}", ends=(0, 3)) as one:
                if one.code != 0:
                    cells.append("refused")
                    continue
                at_end = [abs(one.number(key) - value) for key, value in exact.items()]
                cells.append(f"{short(max(at_end))} ({short(one.summary.get('error_estimate'))})")
        rows.append([case, *cells])
    what = "`geodesic-ivp run CASE --set solver.accuracy=1e-10`: the error of t and x at the end, against 200 windows\n"
    what += "of 24 nodes in 32 digits. In parentheses stands what the run estimates for all its nodes.\n\n"
    return what + table(["asked for", "1e-4", "1e-7", "1e-10", "1e-13"], rows)


@section("Costs of a solve with its certificate, quartic case")
def costs():
    def row(name, changes, grids, tries):
        times = []
        for n in grids:
            runs = [run("quartic", f"{changes} grid.n_gamma={n}") for _ in range(tries)]
            times.append(min(one.number("solve_seconds") for one in runs))
        return [name, *map(duration, times), f"{times[1] / times[0]:.1f}"]

    schemes = [("SBP21", ""), ("SBP42", "scheme.sbp=SBP42"), ("SBP42 weak", "scheme.sbp=SBP42 scheme.form=weak")]
    rows = [row(f"{name}, 10⁵ and 10⁶ nodes", it, (100_000, 1_000_000), 3) for name, it in schemes]
    for sbp in ("SBP21", "SBP42"):
        changes = f"scheme.sbp={sbp} solver.system=doubled"
        rows.append(row(f"doubled, {sbp}, 2 000 and 20 000 nodes", changes, (2000, 20_000), 1))
    text = "`geodesic-ivp run quartic --set grid.n_gamma=100000`: time grows linearly with the number of nodes.\n\n"
    return text + table(["", "time", "with ten times the nodes", "ratio"], rows)
