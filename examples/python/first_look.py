# /// script
# requires-python = ">=3.11"
# dependencies = ["matplotlib", "numpy", "pandas"]
# ///
# %% [markdown]
# # A first look from Python
#
# This notebook runs `geodesic-ivp`, reads its tables and its summary, and draws them. It needs the program on the PATH,
# pandas and matplotlib; `polars.read_csv` reads the tables just as well. Run it as a script (`uv run
# examples/python/first_look.py`), or open it in an editor that knows cells. Files and pictures go into
# `results/python`. Words and symbols are explained in `docs/guide.md`.


# %%
import io
import json
import subprocess
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

PROGRAM = "geodesic-ivp"
FOLDER = Path("results/python")
FOLDER.mkdir(parents=True, exist_ok=True)


# %% [markdown]
# ## Running the program
#
# A table is read in one line. A mistake in a case ends the program with a message on standard error, and `check=True`
# turns that into an exception.


# %%
def run(case, **changes):
    """One table with all columns of a run, straight from the pipe. Write `grid__n_gamma=64` for grid.n_gamma."""
    settings = [part for key, value in changes.items() for part in ("--set", f"{key.replace('__', '.')}={value}")]
    done = subprocess.run(
        [PROGRAM, "run", case, "--stdout", "--quiet", *settings], check=True, stdout=subprocess.PIPE, text=True
    )
    return pd.read_csv(io.StringIO(done.stdout))


# %% [markdown]
# ## The time mesh that nobody asked for
#
# The nodes are even in γ and uneven in t: ṫ = dt/dγ = Q_t/g00 is small where the potential is high. A dot is d/dγ.

# %%
quartic = run("quartic")
figure, axes = plt.subplots()
axes.plot(quartic["t"], quartic["x"], "o-", markersize=4)
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
    table = run("quartic", scheme__form=form)
    axes.semilogy(table["gamma"], np.abs(table["delta_q_t"]) + tiny, "o", label=f"ΔQ_t, {form}")
    axes.semilogy(table["gamma"], np.abs(table["delta_k"]) + tiny, "-", label=f"ΔK, {form}")
axes.set(xlabel="γ", title="Charge and second invariant")
axes.legend()
figure.savefig(FOLDER / "charge.svg")

# %% [markdown]
# ## Errors, by the program's own judgement
#
# `run --out` leaves files. `summary.json` says how far t and x are off, at most about.

# %%
nodes = [16, 32, 64, 128, 256]
figure, axes = plt.subplots()
for sbp in ["SBP21", "SBP42"]:
    errors = []
    for n in nodes:
        out = FOLDER / f"{sbp}-{n}"
        settings = ["--set", f"scheme.sbp={sbp}", "--set", f"grid.n_gamma={n}"]
        subprocess.run([PROGRAM, "run", "quartic", "--quiet", "--out", out, *settings], check=True)
        summary = json.loads((out / "summary.json").read_text())
        errors.append(summary["error_t_final"])
    slope = np.polyfit(np.log(1 / (np.array(nodes) - 1)), np.log(errors), 1)[0]
    axes.loglog(nodes, errors, "o-", label=f"{sbp}, slope {slope:.2f}")
    print(f"{sbp}: the error of t falls like Δγ^{slope:.2f}")
axes.set(xlabel="N", ylabel="error of t at the end")
axes.legend()
figure.savefig(FOLDER / "errors.svg")

# %% [markdown]
# ## A case from Python
#
# A case is text; `-` reads it from standard input. A pendulum in Newton's limit, at times of our choice:

# %%
PENDULUM = """
title = "A pendulum from Python"
potential.formula = { expression = "g*(1 - cos(x))", parameters = { g = 1.0 } }
particle.c = 3000.0
initial = { t = 0.0, x = 2.5, t_dot = 1.0, velocity = 0.0 }
grid.t_f = 20.0
solver.accuracy = 1e-10
"""
done = subprocess.run(
    [PROGRAM, "run", "-", "--stdout", "--quiet", "--sample-t", "0:20:0.1", "--samples-only"],
    input=PENDULUM, check=True, stdout=subprocess.PIPE, text=True,
)  # fmt: skip
pendulum = pd.read_csv(io.StringIO(done.stdout))
figure, axes = plt.subplots()
axes.plot(pendulum["t"], pendulum["x"])
axes.set(xlabel="t", ylabel="angle", title="A pendulum, released at 2.5 rad")
figure.savefig(FOLDER / "pendulum.svg")
print(f"pictures in {FOLDER}")
