# /// script
# requires-python = ">=3.10"
# dependencies = ["geodesic-ivp", "matplotlib", "pandas"]
#
# [tool.uv.sources]
# geodesic-ivp = { path = "../.." }
# ///
# %% [markdown]
# # The figures of the paper from CSV
#
# A. Rothkopf and J. Nordström, *A symmetry and Noether charge preserving discretization of initial value problems*
# (2023), section 4: the linear and the quartic potential on 32 nodes, with SBP21 and SBP42. This notebook draws what
# the paper shows. It needs the program on the PATH, pandas and matplotlib. Run it as a script (`uv run
# examples/python/paper_figures.py`), or open it in an editor that knows cells. Pictures go into `results/paper`.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

import geodesic_ivp

FOLDER = Path("results/paper")
FOLDER.mkdir(parents=True, exist_ok=True)
CASES = {"linear": ["SBP21", "SBP42"], "quartic": ["SBP21", "SBP42"]}


def converged(name):
    """Errors on many grids, and the slopes fitted to them. Commands other than `run` are called by their names."""
    out = FOLDER / f"converge-{name}"
    geodesic_ivp.command("converge", name, "--out", out, "--force", "--quiet")
    return [pd.DataFrame(geodesic_ivp.read_table(out / f"{table}.csv")) for table in ("convergence", "slopes")]


def drawn(name, title, columns, logarithmic=False):
    """One picture of a case, a panel for each operator; `columns` are pairs of a column and its label."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for panel, sbp in zip(panels, CASES[name]):
        run = geodesic_ivp.run(name, set={"scheme.sbp": sbp, "solver.system": "doubled"})
        table = pd.concat([run.to_pandas(of) for of in ("trajectory", "residuals", "branches")], axis=1)
        gamma = run.trajectory.gamma
        for column, label in columns:
            values = table[column].abs() if logarithmic else table[column]
            panel.plot(gamma, values, "o", markersize=4, label=label)
        panel.set(title=sbp, xlabel="γ", yscale="log" if logarithmic else "linear")
        panel.legend()
    figure.suptitle(f"{title}, {name} potential")
    word = title.split()[0].strip(":").lower()
    figure.savefig(FOLDER / f"{name}-{word}.svg")


# %% [markdown]
# ## Both branches, the emergent time mesh, the charge and the geodesic equations
#
# The doubled system solves for two copies of the world-line, which agree. Zeros are not drawn on a logarithmic axis.

# %%
for name in CASES:
    drawn(name, "Branches of the doubled system", [("t_1", "t₁"), ("x_1", "x₁"), ("t_2", "t₂"), ("x_2", "x₂")])
    drawn(name, "Mesh in time: dt/dγ", [("t_dot", "dt/dγ")])
    drawn(name, "Charge: its deviation", [("delta_q_t", "|ΔQ_t|")], logarithmic=True)
    drawn(name, "Residuals of the geodesic equations", [("delta_g_t", "|ΔG^t|"), ("delta_g_x", "|ΔG^x|")], True)

# %% [markdown]
# ## Convergence
#
# Errors against a Taylor series, with the slopes that the program fits.

# %%
figure, panels = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
for panel, name in zip(panels, CASES):
    points, slopes = converged(name)
    for (sbp, rows), quantity in ((group, q) for group in points.groupby("sbp") for q in ("eps_t_l2", "eps_x_l2")):
        slope = slopes[(slopes["sbp"] == sbp) & (slopes["quantity"] == quantity)]["slope"].iloc[0]
        panel.loglog(rows["delta_gamma"], rows[quantity], "o-", label=f"{sbp} {quantity}, slope {slope:.2f}")
    panel.set(title=name, xlabel="Δγ", ylabel="error in L2")
    panel.legend()
figure.savefig(FOLDER / "convergence.svg")
print(f"pictures in {FOLDER}")
