# SPDX-License-Identifier: GPL-3.0-or-later
# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---
# %% [markdown]
# # My recording
# From the sound of a bouncing ball to its coefficient of restitution ε(v): impacts, samples, law, picture, table, report.
# As a script: `python my_recording.py drop.wav [FOLDER]`; without a recording it takes `samples/clean.flac`.

# %%
import os
import sys

import matplotlib.pyplot as plt

import bouncelab as bl

given = [] if "ipykernel" in sys.modules else sys.argv[1:]
recording = given[0] if given else os.path.join(os.path.dirname(os.path.abspath(
    globals().get("__file__", "my_recording.py"))), "..", "..", "..", "samples", "clean.flac")
folder = given[1] if len(given) > 1 else "."

# %% [markdown]
# ## Impacts
# Nothing has to be set. `t` is in seconds from the first sample, `sigma` its standard error.

# %%
onsets = bl.detect(recording)
print(onsets.message)
print(f"median standard error of a time: {sorted(onsets.sigma)[len(onsets) // 2] * 1e6:.2g} µs")

# %% [markdown]
# ## Coefficients of restitution
# Ratios of neighbouring intervals. Who knows the ball names it: `ball="table-tennis", plate="concrete"`; then air drag
# and the time of contact are then known beforehand, and its interval is narrower.

# %%
samples = bl.restitution(onsets)
print(samples)

# %% [markdown]
# ## The law
# `fit.eps(v)` gives values with 95 % intervals; they are NaN outside the speeds of the data.

# %%
fit = bl.fit(samples)
print(fit.answer)
for v, found in fit.nodes.items():
    print(f"ε({v:.3g} m/s) = {found.value:.4f}, 95 %: {found.lo95:.4f} to {found.hi95:.4f}")

# %%
figure, ax = plt.subplots(figsize=(7, 4), layout="constrained")
bl.plot.restitution(fit, ax=ax)
figure.savefig(os.path.join(folder, "my_recording.png"), dpi=150)
plt.show()

# %% [markdown]
# ## To take along
# The tables are those of the command line; the report is one file that needs no network.

# %%
samples.to_csv(os.path.join(folder, "samples.csv"), force=True)
fit.report(os.path.join(folder, "report.html"), force=True)
