#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The law's likelihood in NumPy, fitted by iminuit: the baseline of fit_bench.

Same density (normal-Laplace, by log_ndtr), same parameters (eps at three speeds, two quadratics in log v), same start as
a user would take; MIGRAD, HESSE, and MINOS at 68 % and 95 % for the three nodes. Prints seconds and results as JSON.
usage: fit_iminuit.py samples.csv
"""
import json
import sys
import time

import numpy as np
from iminuit import Minuit
from scipy.special import log_ndtr

C = {2: -1.1534488580952884, 4: 0.7982665609447948, 5: 4.0 / 15.0}
NODES = np.array([0.25, 0.6, 1.2])


def main():
    data = np.genfromtxt(sys.argv[1], delimiter=",", names=True)
    v, eps = data["v_mps"], data["eps"]
    tau = np.maximum(np.nan_to_num(data["sigma_eps"]), 1e-8)
    terms = lambda s: np.stack([C[i] * s ** (0.1 * i) for i in C], axis=1)
    rows = terms(v) @ np.linalg.inv(terms(NODES))
    x = np.log(v / np.median(v))

    def negative_loglik(q1, q2, q3, b0, b1, b2, a0, a1, a2):
        d = eps - 1.0 - rows @ (np.array([q1, q2, q3]) - 1.0)
        below = np.exp(b0 + x * (b1 + x * b2))
        above = np.exp(a0 + x * (a1 + x * a2))
        z, at, ct = d / tau, tau / above, tau / below
        # each side as exp(exponent) Phi(...), stable in both tails
        left = at * (0.5 * at - z) + log_ndtr(z - at)
        right = ct * (0.5 * ct + z) + log_ndtr(-z - ct)
        return -np.sum(np.logaddexp(left, right) - np.log(below + above))

    width = np.log(np.mean(np.abs(eps - np.median(eps))))
    begin = time.perf_counter()
    m = Minuit(negative_loglik, 0.982, 0.98, 0.976, width, -1.0, 0.0, width, -1.0, 0.0)
    m.errordef = Minuit.LIKELIHOOD
    m.errors = [1e-4] * 3 + [0.1] * 6
    m.migrad()
    seconds_fit = time.perf_counter() - begin
    m.hesse()
    ends = []
    for level in (0.6827, 0.95):
        m.minos("q1", "q2", "q3", cl=level)
        ends.append([[m.values[n] + m.merrors[n].lower, m.values[n] + m.merrors[n].upper] for n in ("q1", "q2", "q3")])
    print(json.dumps({"seconds_fit": seconds_fit, "seconds": time.perf_counter() - begin, "n_calls": m.nfcn,
                      "valid": m.valid, "loglik": -m.fval, "nodes": list(m.values)[:3], "se": list(m.errors)[:3],
                      "ci68": ends[0], "ci95": ends[1]}))


main()
