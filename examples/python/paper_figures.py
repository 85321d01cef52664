# /// script
# requires-python = ">=3.11"
# dependencies = ["matplotlib", "pandas"]
# ///
# %% [markdown]
# # The figures of the paper from CSV
#
# A. Rothkopf and J. Nordström, *A symmetry and Noether charge preserving discretization of initial value problems*
# (2023), section 4: the linear and the quartic potential on 32 nodes, with SBP21 and SBP42. This notebook draws what
# the paper shows. It needs the program on the PATH, pandas and matplotlib. Run it as a script (`uv run
# examples/python/paper_figures.py`), or open it in an editor that knows cells. Pictures go into `results/paper`.

# %%
import subprocess
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

FOLDER = Path("results/paper")
CASES = {"linear": ["SBP21", "SBP42"], "quartic": ["SBP21", "SBP42"]}


def tables(command, *arguments, files):
    """Tables that a command writes."""
    out = FOLDER / "-".join([command, *arguments]).replace("=", "-")
    line = ["geodesic-ivp", command, *arguments, "--out", out, "--force", "--quiet"]
    subprocess.run(line, check=True)
    return [pd.read_csv(out / name) for name in files]


def drawn(name, title, columns, logarithmic=False):
    """One picture of a case, a panel for each operator; `columns` are pairs of a column and its label."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for panel, sbp in zip(panels, CASES[name]):
        run = ["run", name, "--set", f"scheme.sbp={sbp}", "--set", "solver.system=doubled"]
        table = pd.concat(tables(*run, files=["trajectory.csv", "residuals.csv", "branches.csv"]), axis=1)
        gamma = table["gamma"].iloc[:, 0]
        for column, label in columns:
            values = table[column].abs() if logarithmic else table[column]
            panel.plot(gamma, values, "o", markersize=4, label=label)
        panel.set(title=sbp, xlabel="γ", yscale="log" if logarithmic else "linear")
        panel.legend()
    figure.suptitle(f"{title}, {name} potential")
    figure.savefig(FOLDER / f"{name}-{title.split()[0].strip(":").lower()}.svg")


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
    points, slopes = tables("converge", name, files=["convergence.csv", "slopes.csv"])
    for (sbp, rows), quantity in ((group, q) for group in points.groupby("sbp") for q in ("eps_t_l2", "eps_x_l2")):
        slope = slopes[(slopes["sbp"] == sbp) & (slopes["quantity"] == quantity)]["slope"].iloc[0]
        panel.loglog(rows["delta_gamma"], rows[quantity], "o-", label=f"{sbp} {quantity}, slope {slope:.2f}")
    panel.set(title=name, xlabel="Δγ", ylabel="error in L2")
    panel.legend()
figure.savefig(FOLDER / "convergence.svg")
print(f"pictures in {FOLDER}")
