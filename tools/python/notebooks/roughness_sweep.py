# SPDX-License-Identifier: GPL-3.0-or-later
# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
# ---
# %% [markdown]
# # How rough is rough?
# The scatter of the coefficient of restitution depends on one number of ball and surface, q = c s₂ (docs/physics.md,
# section 7): s₂ the mean square offset of the contact over the ball's radius, c = 5/7 for a solid ball without slip.
# Balls with ever more asperities are dropped, and the width of p(ε) is held against the closed form, in which nothing
# is fitted.

# %%
import os
import sys

import matplotlib.pyplot as plt
import numpy as np

import bouncelab as bl

given = [] if "ipykernel" in sys.modules else sys.argv[1:]
DROPS = int(given[0]) if given else 100
ASPERITIES = [int(n) for n in given[1].split(",")] if len(given) > 1 else [30_000, 100_000, 300_000, 1_000_000]
FOLDER = given[2] if len(given) > 2 else "."
LAW = "series:A2=0.0467,A4=0.1339,A5=-0.2876"
WIDTH = 1e-3  # of the radii of the asperities, 0.5e-3 to 1.5e-3 of the ball's


def q_of(n):
    """The roughness of a solid ball of n asperities, uniform radii, contacts without slip."""
    return 5 / 7 * np.sqrt(np.pi * WIDTH / n) / 2


# %% [markdown]
# ## One ball
# Each impact's fluctuation is two exponentials about ε(v), whose widths depend on the speed and, by the path S, on the
# drop's earlier impacts: what they have put into spin and sideways motion can come back.


# %%
def fluctuations(n):
    """Speeds, fluctuations and their predicted sides; columns of drops."""
    impacts = bl.simulate(drops=DROPS, impacts=60, asperities=n, law=LAW, radius_law="uniform:5e-4,1.5e-3", progress=True)
    shape = (-1, 60)
    v, eps = impacts.v.reshape(shape), bl.eps_of_law(LAW, impacts.v).reshape(shape)
    slope = (bl.eps_of_law(LAW, v * 1.001) - bl.eps_of_law(LAW, v * 0.999)) / (0.002 * v)
    steps = ((1 + eps) * v) ** 2
    path = np.cumsum(steps, axis=1) - steps
    return v, impacts.eps.reshape(shape) - eps, bl.fluctuation_sides(q_of(n), v, eps, path, slope)


def measured_and_predicted(r, sides, chosen):
    """Root mean square of the fluctuations, its standard error by drop, and what the closed form says."""
    second = np.array([np.mean(row[c] ** 2) for row, c in zip(r, chosen) if c.any()])
    rms = np.sqrt(second.mean())
    # the mean square of two exponentials: variance below^2 + above^2, mean above - below
    predicted = np.sqrt(np.mean((sides.below**2 + sides.above**2 + (sides.above - sides.below) ** 2)[chosen]))
    return rms, second.std(ddof=1) / np.sqrt(len(second)) / (2 * rms), predicted


# %% [markdown]
# ## The sweep
# With uniform radii s₂ falls as 1/√N: ten times the asperities make the scatter about three times narrower.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
speeds = (0.6, 0.8, 1.0)
table = []
for n in ASPERITIES:
    v, r, sides = fluctuations(n)
    for speed in speeds:
        table.append((n, speed, *measured_and_predicted(r, sides, abs(v - speed) < 0.05)))
    print(f"N = {n:9,}, q = {q_of(n):.2e}: " + ", ".join(
        f"{row[1]} m/s: {row[2]:.2e} ± {row[3]:.0e}, predicted {row[4]:.2e}" for row in table[-len(speeds):]))
table = np.array(table)
for k, speed in enumerate(speeds):
    n, _, rms, error, predicted = table[table[:, 1] == speed].T
    left.errorbar(n, rms, 2 * error, fmt="o", ms=4, color=f"C{k}", label=f"{speed} m/s")
    left.plot(n, predicted, color=f"C{k}", lw=1)
left.set(xscale="log", yscale="log", xlabel="asperities N", ylabel="rms of ε̃ - ε(v); lines: closed form")
left.legend(frameon=False)

# %% [markdown]
# ## Its form
# The last ball, all impacts: each fluctuation over its own predicted side. If the closed form holds the two sides are
# exponentials of mean 1.

# %%
scaled = np.where(r < 0, -r / sides.below, r / np.maximum(sides.above, 1e-300))[:, 1:].ravel()
is_below = (r < 0)[:, 1:].ravel()
bins = np.linspace(0, 6, 25)
for side, name, colour in ((is_below, "below ε(v)", "C0"), (~is_below, "above ε(v)", "C3")):
    counts = np.histogram(scaled[side], bins)[0]
    right.semilogy((bins[1:] + bins[:-1]) / 2, np.where(counts > 0, counts / (side.sum() * np.diff(bins)), np.nan), "o",
                   ms=4, color=colour, label=f"{name}, mean {scaled[side].mean():.2f}")
right.semilogy(bins, np.exp(-bins), "k", lw=1, label="exponential")
right.set(xlabel="|ε̃ - ε(v)| over its predicted mean", ylabel="density")
right.legend(frameon=False)
figure.savefig(os.path.join(FOLDER, "roughness_sweep.png"), dpi=150)
plt.show()
