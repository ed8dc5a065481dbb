# SPDX-License-Identifier: GPL-3.0-or-later
# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---
# %% [markdown]
# # My recording
# From the sound of a bouncing ball to its coefficient of restitution ε(v): picture, tables, report.
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
# ## The answer
# Nothing has to be set. Who knows the ball names it: `ball="table-tennis", plate="concrete"`; air drag and the time of
# contact are then known beforehand, and the interval is narrower. The files of the command line are in the folder, among
# them `report.html`, which needs no network.

# %%
analysis = bl.analyze(recording, out=os.path.join(folder, "analysis"), force=True)
fit = analysis.fit
print(fit.answer)
print(analysis.report)

# %% [markdown]
# `fit.eps(v)` gives values with 95 % intervals; they are NaN outside the speeds of the data.

# %%
for v, found in fit.nodes.items():
    print(f"ε({v:.3g} m/s) = {found.value:.4f}, 95 %: {found.lo95:.4f} to {found.hi95:.4f}")

# %%
figure, ax = plt.subplots(figsize=(7, 4), layout="constrained")
bl.plot.restitution(fit, ax=ax)
figure.savefig(os.path.join(folder, "my_recording.png"), dpi=150)
plt.show()

# %% [markdown]
# ## Impacts and coefficients of restitution
# `t` is in seconds from the first sample, `sigma` its standard error. Samples are ratios of neighbouring intervals.

# %%
onsets, samples = analysis.onsets, analysis.samples
print(f"median standard error of a time: {sorted(onsets.sigma)[len(onsets) // 2] * 1e6:.2g} µs")
print(samples)
