# SPDX-License-Identifier: GPL-3.0-or-later
# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---
# %% [markdown]
# # The paper in ten minutes
# Montaine, Heckel, Kruelle, Schwager & Pöschel, "Coefficient of restitution as a fluctuating quantity", Phys. Rev. E 84,
# 041306 (2011), doi:10.1103/PhysRevE.84.041306: a rough steel ball is dropped on a glass plate again and again, and its
# coefficient of restitution fluctuates. Here the ball is simulated, the simulation made audible, the impacts found in
# the sound and the law fitted to what was found, which can then be held against what went in.

# %%
import os
import sys

import matplotlib.pyplot as plt
import numpy as np

import bouncelab as bl

given = [] if "ipykernel" in sys.modules else sys.argv[1:]
DROPS = int(given[0]) if given else 200  # of the paper's 2,320; some seconds each 100
ASPERITIES = int(given[1]) if len(given) > 1 else 1_000_000  # as in the paper
FOLDER = given[2] if len(given) > 2 else "."
LAW = "series:A2=0.0467,A4=0.1339,A5=-0.2876"  # the paper's

# %% [markdown]
# ## The experiment
# Drops from 9 to 10 cm with 95 impacts each; the sound a sensor on the plate would record, with noise at 30 dB. The
# truth is kept beside the sound: the last column says how well the impacts are timed.

# %%
impacts = bl.simulate(drops=DROPS, impacts=95, asperities=ASPERITIES, law=LAW, progress=True)
sound = bl.synthesize(impacts, positions="drawn", progress=True)
onsets = bl.detect(sound, progress=True)
print(f"{len(impacts)} impacts, {sound.duration / 60:.1f} minutes of sound, {len(onsets)} found")

# %%
samples = bl.restitution(onsets)
fit = bl.fit(samples, progress=True)
print(fit.answer)
went_in = {"A2": 0.0467, "A4": 0.1339, "A5": -0.2876}
for name, found in fit.parameters.items():
    print(f"{name} = {found.value:.4f}, 95 %: {found.lo95:.4f} to {found.hi95:.4f}; {went_in[name]} went in")

# %% [markdown]
# ## Its figures
# Left: the coefficient of restitution against the speed (the paper's figure 3). The law is where impacts are most
# frequent; dashed, the law that went in. Right: the distribution of ε in windows of speed 0.1 m/s wide (figure 2). On
# the logarithmic scale both sides are nearly straight: two exponentials, no Gaussian.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
bl.plot.restitution(fit, ax=left)
v = np.linspace(samples.v.min(), samples.v.max(), 200)
left.plot(v, bl.eps_of_law(LAW, v), "--", color="C3", label="went in", zorder=4)
left.legend(frameon=False)
windows = [w for w in fit.results["histograms"] if w["bins"]["counts"] and w["n"] > 50]
for k, window in enumerate(windows[:: max(1, len(windows) // 3)][:3]):
    edges, counts = np.array(window["bins"]["eps_edges"]), np.array(window["bins"]["counts"])
    middle, density = (edges[1:] + edges[:-1]) / 2, counts / (window["n"] * np.diff(edges))
    seen = counts > 0
    name = f"{window['v_lo_mps']:.2g} to {window['v_hi_mps']:.2g} m/s"
    right.semilogy(middle[seen], density[seen], ".", color=f"C{k}", label=name)
    right.semilogy(window["curve"]["eps"], window["curve"]["density"], color=f"C{k}", lw=1)
lowest = min(1 / (w["n"] * np.diff(w["bins"]["eps_edges"]).max()) for w in windows)  # of a bin with one impact
right.set_ylim(bottom=lowest / 2)
right.set_xlabel("coefficient of restitution ε")
right.set_ylabel("density p(ε)")
right.legend(frameon=False)
figure.savefig(os.path.join(FOLDER, "paper.png"), dpi=150)
plt.show()

# %% [markdown]
# ## For other simulations
# Draws of ε as they scatter at one speed, for a model of grains:

# %%
print(fit.sample(0.6, 5, rng=np.random.default_rng(1)).round(4))
fit.report(os.path.join(FOLDER, "paper.html"), title=f"The paper with {DROPS} drops", force=True)
