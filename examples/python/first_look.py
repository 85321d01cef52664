# /// script
# requires-python = ">=3.10"
# dependencies = ["geodesic-ivp", "matplotlib", "numpy", "pandas"]
#
# [tool.uv.sources]
# geodesic-ivp = { path = "../.." }
# ///
# %% [markdown]
# # A first look from Python
#
# This notebook runs `geodesic-ivp`, and draws its tables and its summary. It needs the package `geodesic_ivp` (`pip
# install .` in a clone of this repository), pandas and matplotlib. Run it as a script, or open it in an editor that
# knows cells. Files and pictures go into `results/python`. Words and symbols are explained in `docs/guide.md`, and the
# package in `docs/python.md`.


# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import geodesic_ivp

FOLDER = Path("results/python")
FOLDER.mkdir(parents=True, exist_ok=True)


# %% [markdown]
# ## The time mesh that nobody asked for
#
# The nodes are even in γ and uneven in t: ṫ = dt/dγ = Q_t/g00 is small where the potential is high. A dot is d/dγ.
# What a run prints tells whether to believe it. A mistake in a case is an exception.

# %%
run = geodesic_ivp.run("quartic")
print(run)
figure, axes = plt.subplots()
axes.plot(run.trajectory.t, run.trajectory.x, "o-", markersize=4)
axes.set(xlabel="t", ylabel="x", title="The quartic oscillator on 32 nodes")
figure.savefig(FOLDER / "motion.svg")

# %% [markdown]
# ## The charge, and what it does not say
#
# Q_t is exact at every node, in the strong form at every node but the last. K = g00 ṫ² − ẋ² is a constant of the
# motion, too, but no scheme keeps it exactly. So it says how good x is.

# %%
figure, axes = plt.subplots()
tiny = 1e-17  # a logarithm has no zero
for form in ["strong", "weak"]:
    table = geodesic_ivp.run("quartic", set={"scheme.form": form}).residuals
    axes.semilogy(table.gamma, np.abs(table.delta_q_t) + tiny, "o", label=f"ΔQ_t, {form}")
    axes.semilogy(table.gamma, np.abs(table.delta_k) + tiny, "-", label=f"ΔK, {form}")
axes.set(xlabel="γ", title="Charge and second invariant")
axes.legend()
figure.savefig(FOLDER / "charge.svg")

# %% [markdown]
# ## Errors, by the program's own judgement
#
# The summary says how far t and x are off, at most about.

# %%
nodes = [16, 32, 64, 128, 256]
figure, axes = plt.subplots()
for sbp in ["SBP21", "SBP42"]:
    runs = [geodesic_ivp.run("quartic", set={"scheme.sbp": sbp, "grid.n_gamma": n}) for n in nodes]
    errors = [run.summary["error_final"]["t"] for run in runs]
    slope = np.polyfit(np.log(1 / (np.array(nodes) - 1)), np.log(errors), 1)[0]
    axes.loglog(nodes, errors, "o-", label=f"{sbp}, slope {slope:.2f}")
    print(f"{sbp}: the error of t falls like Δγ^{slope:.2f}")
axes.set(xlabel="N", ylabel="error of t at the end")
axes.legend()
figure.savefig(FOLDER / "errors.svg")

# %% [markdown]
# ## A case from Python
#
# A case may be a text, or a dict. A pendulum in Newton's limit, at times of our choice:

# %%
PENDULUM = {
    "title": "A pendulum from Python",
    "potential.formula": "g*(1 - cos(x))",
    "parameters.g": 1.0,
    "particle.c": 3000.0,
    "initial": {"t": 0.0, "x": 2.5, "t_dot": 1.0, "velocity": 0.0},
    "grid.t_f": 20.0,
    "solver.accuracy": 1e-10,
}
pendulum = geodesic_ivp.run(PENDULUM, sample_t=np.linspace(0, 20, 201)).samples
figure, axes = plt.subplots()
axes.plot(pendulum.t, pendulum.x)
axes.set(xlabel="t", ylabel="angle", title="A pendulum, released at 2.5 rad")
figure.savefig(FOLDER / "pendulum.svg")

# %% [markdown]
# ## Many runs
#
# A sweep is a table with a row for each run. Small swings take a period of 2π. Here swings of all sizes are as far as
# they have come after a quarter of that, as a DataFrame of pandas.

# %%
quarter = {"grid.t_f": float(np.pi / 2)}
swings = geodesic_ivp.vary(PENDULUM, {"initial.x": np.linspace(0.25, 3.0, 12)}, set=quarter).to_pandas()
print(swings[["initial.x", "x", "verdict"]])
figure, axes = plt.subplots()
axes.plot(swings["initial.x"], swings["x"], "o-")
axes.set(xlabel="amplitude", ylabel="angle after π/2", title="A pendulum is no oscillator of one period")
figure.savefig(FOLDER / "swings.svg")
print(f"pictures in {FOLDER}")
