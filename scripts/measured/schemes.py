"""Errors, charges and costs of the schemes: what the pages on schemes and theory quote."""

from .page import Results, code, duration, run, section, short, sets, table


@section("The paper's numbers: slopes of the errors")
def orders():
    with Results("converge", "--verbose") as swept:
        return swept.text()


GRIDS = (32, 320, 3200, 32_000, 320_000)


@section("How critical the points are: the largest entry of the gradient of the doubled action")
def gradient():
    rows = []
    for sbp in ("SBP21", "SBP42"):
        for system, grids in (("physical-limit", GRIDS), ("doubled", GRIDS[:-1])):
            rows.append([f"{sbp}, {system}", *[""] * len(GRIDS)])
            for k, n in enumerate(grids, 1):
                with run("quartic", f"scheme.sbp={sbp} solver.system={system} grid.n_gamma={n}") as one:
                    rows[-1][k], line = short(one.number("gradient_norm")), one.line
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
    what = "The paper's four base cases (N = 32) in both systems: the largest of all eight.\n"
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
            "converge", "quartic", "--n-gamma", "65,129,257", "--sbp", sbp, "--form", form
        ) as swept:
            finest = swept.rows("convergence.csv")[-1]
            slopes = {row["quantity"]: f"{float(row['slope']):.2f}" for row in swept.rows("slopes.csv")}
            column += [short(finest["eps_x_final"]), short(finest["eps_t_final"])]
            column += [f"{slopes[f'eps_x_{where}']}, {slopes[f'eps_t_{where}']}" for where in ("final", "l2")]
        with run("quartic", f"{base} grid.gamma_f=100.0 grid.n_gamma=2001", ends=(0, 3)) as long:
            column.append(short(long.number("max_abs_delta_k")) if long.code == 0 else "no critical point")
        columns.append(column)
    labels = ["ΔQ_t at the last node, N = 32", "max \\|ΔQ_t\\| over all nodes, N = 32, 40 digits, doubled"]
    labels += ["ε_x(γ_f), N = 257 (odd)", "ε_t(γ_f), N = 257 (odd)", "slopes of ε_x(γ_f), ε_t(γ_f) from N = 65"]
    labels += ["slopes of ε_x, ε_t in L2", "max \\|ΔK\\|, γ_f = 100, N = 2001"]
    return table(["", *(f"{sbp} {form}" for sbp, form in names)], [[a, *b] for a, b in zip(labels, zip(*columns))])


@section("Operators: orders and errors at γ_f, quartic case in 60 digits")
def operators():
    names = "SBP21,SBP42,SBP63,SBP84,GLL8,GLL16"
    sweep = ["--sbp", names, "--form", "strong,weak", "--n-gamma", "256,512,1024,2048", "--fit-range", "200:2100"]
    whats = ("slope of ε_x", "slope of ε_t", "ε_x at N = 1024")
    whats = [(what, form) for what in whats for form in ("strong", "weak")]
    rows = []
    with Results("converge", "quartic", *sweep, *sets("solver.digits=60")) as swept:
        for sbp in names.split(","):
            rows.append([sbp])
            for what, form in whats:
                at = [row for row in swept.rows("convergence.csv") if (row["sbp"], row["form"]) == (sbp, form)]
                nearest = min(at, key=lambda row: abs(int(row["n_gamma"]) - 1024))
                slopes = [row for row in swept.rows("slopes.csv") if (row["sbp"], row["form"]) == (sbp, form)]
                slopes = {row["quantity"]: row["slope"] for row in slopes}
                slope = slopes["eps_t_final" if "ε_t" in what else "eps_x_final"]
                rows[-1].append(f"{float(slope):.2f}" if "slope" in what else short(nearest["eps_x_final"]))
        return code(swept.line) + "\n" + table(["", *(f"{what}, {form}" for what, form in whats)], rows)


@section("Down to rounding: ε_x(γ_f) of the quartic case in f64")
def rounding():
    grids = "1024,16384,65536,262144,1000000,4000000"
    rows = []
    for form in ("strong", "weak"):
        sweep = ["--sbp", "SBP21,SBP42" if form == "strong" else "SBP42", "--form", form, "--n-gamma", grids]
        with Results("converge", "quartic", *sweep) as swept:
            points = swept.rows("convergence.csv")
            for sbp in dict.fromkeys(row["sbp"] for row in points):
                errors = [short(row["eps_x_final"]) for row in points if row["sbp"] == sbp]
                slopes = swept.rows("slopes.csv")
                fitted = next(row for row in slopes if (row["sbp"], row["quantity"]) == (sbp, "eps_x_final"))
                slope = "none"
                if fitted["slope"]:
                    slope = f"{float(fitted['slope']):.3f}, {fitted['n_min']} … {fitted['n_max']}"
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
    cases = "quartic linear harmonic morse double-well pendulum pendulum-separatrix double-well-barrier power-20"
    cases += " tanh-wall"
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
    what = "Errors of t and x at the end against a run of 200 windows of 24 nodes in 32 digits; in parentheses the\n"
    what += "run's own estimate, which is for all nodes.\n"
    return what + "\n" + code("geodesic-ivp run quartic --set solver.accuracy=1e-10") + "\n" + table(
        ["asked for", "1e-4", "1e-7", "1e-10", "1e-13"], rows
    )


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
    def row(name, changes, grids, tries):
        times = []
        for n in grids:
            runs = [run("quartic", f"{changes} grid.n_gamma={n}") for _ in range(tries)]
            times.append(min(one.number("solve_seconds") for one in runs))
        return [name, *map(duration, times), f"{times[1] / times[0]:.1f}"]

    schemes = [("SBP21", ""), ("SBP42", "scheme.sbp=SBP42"), ("SBP42 weak", "scheme.sbp=SBP42 scheme.form=weak")]
    rows = [row(f"`run`, {name}: solve with certificate", it, (100_000, 1_000_000), 3) for name, it in schemes]
    for sbp in ("SBP21", "SBP42"):
        changes = f"scheme.sbp={sbp} solver.system=doubled"
        rows.append(row(f"doubled, {sbp}: 2 000 and 20 000 nodes", changes, (2000, 20_000), 1))
    return table(["", "10⁵ nodes", "10⁶ nodes", "ratio"], rows)
