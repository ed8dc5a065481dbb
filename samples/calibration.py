#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the fit keep within the errors it states? Experiments of known law, simulated and fitted:

    python3 samples/calibration.py --experiments 40 --drops 20 --sound

For each quantity (the most frequent eps at three speeds, the constants of the law) mean and standard deviation of the
pulls (estimate - truth) / se, and the share of the 95 % intervals that hold the truth. Standard errors of these: the
mean's 1 / sqrt(n), the deviation's 1 / sqrt(2 n), the share's sqrt(.95 * .05 / n).
"""

import argparse

import numpy as np

import bouncelab as bl

LAW = {"A2": 0.0467, "A4": 0.1339, "A5": -0.2876}  # of the paper
NODES_MPS = [0.25, 0.6, 1.2]


def samples_of(seed, arguments):
    """One experiment: coefficients of restitution as simulated, or through sound."""
    impacts = bl.simulate(seed=seed, drops=arguments.drops, impacts=arguments.impacts, asperities=arguments.asperities,
                          radius_law=arguments.radius_law, contact=arguments.contact)
    if not arguments.sound:
        return {"drop": impacts.drop, "impact": impacts.impact, "v_mps": impacts.v, "eps": impacts.eps}
    return bl.restitution(bl.detect(bl.synthesize(impacts, seed=seed)), air="none")


def pulls_of(fit, truth):
    """(estimate - truth) / se and whether the 95 % interval holds the truth, of what the fit knows."""
    found = {}
    for node, v_mps in zip(fit.results["curve"]["nodes"], NODES_MPS):
        found[f"eps({v_mps})"] = node["peak"], node["peak_se"]
    for row in fit.results["constants"]["parameters"]:
        found[row["name"]] = row["value"], row.get("se")
    return {name: (value - truth[name]) / se for name, (value, se) in found.items() if value is not None and se}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--experiments", type=int, default=20)
    parser.add_argument("--drops", type=int, default=20)
    parser.add_argument("--impacts", type=int, default=96)
    parser.add_argument("--asperities", type=int, default=1_000_000)
    parser.add_argument("--radius-law", default="uniform:5e-4,1.5e-3")
    parser.add_argument("--contact", default="paper", help="as of `bouncelab simulate`")
    parser.add_argument("--method", default="auto", help="as of `bouncelab fit`")
    parser.add_argument("--sound", action="store_true", help="times from sound, not as simulated")
    arguments = parser.parse_args()
    law = "series:" + ",".join(f"{name}={value}" for name, value in LAW.items())
    truth = dict(LAW, **{f"eps({v})": float(eps) for v, eps in zip(NODES_MPS, bl.eps_of_law(law, NODES_MPS))})
    pulls = {}
    for seed in range(1, arguments.experiments + 1):
        fit = bl.fit(samples_of(seed, arguments), nodes=NODES_MPS, method=arguments.method, goodness_replicates=0)
        for name, pull in pulls_of(fit, truth).items():
            pulls.setdefault(name, []).append(pull)
    print(f"{'':10}{'n':>5}{'pull':>8}{'sd':>8}{'c95':>8}")
    for name, values in pulls.items():
        spread = np.std(values, ddof=1) if len(values) > 1 else np.nan
        print(f"{name:10}{len(values):5}{np.mean(values):8.2f}{spread:8.2f}{np.mean(np.abs(values) < 1.96):8.2f}")


if __name__ == "__main__":
    main()
