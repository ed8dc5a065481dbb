#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The law's likelihood in NumPy, fitted by iminuit: the baseline of fit_bench.

Same density (normal-Laplace, by log_ndtr), same parameters (eps at three speeds, two quadratics in log v), same start as
a user would take; MIGRAD, HESSE, and MINOS at 68 % and 95 % for the three nodes. Prints processor time and results.
usage: fit_iminuit.py SAMPLES.csv   (fit_bench writes them; the name without .csv is the case's)
"""
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from bench_lines import print_line  # noqa: E402
from iminuit import Minuit  # noqa: E402
from scipy.special import log_ndtr  # noqa: E402

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
    np.seterr(all="ignore")  # far from the data on the way there
    begin = time.process_time()
    m = Minuit(negative_loglik, 0.982, 0.98, 0.976, width, -1.0, 0.0, width, -1.0, 0.0)
    m.errordef = Minuit.LIKELIHOOD
    m.errors = [1e-4] * 3 + [0.1] * 6
    m.migrad()
    seconds_fit = time.process_time() - begin
    m.hesse()
    for level in (0.6827, 0.95):
        m.minos("q1", "q2", "q3", cl=level)
    seconds = time.process_time() - begin
    case = Path(sys.argv[1]).stem
    print_line("fit", case, "iminuit, profile intervals", seconds, "s")
    print_line("fit", case, "iminuit, MIGRAD alone", seconds_fit, "s")
    print_line("fit", case, "iminuit, evaluations", m.nfcn, "1")
    print_line("fit", case, "iminuit, valid", int(m.valid), "1")
    for v, value in zip(NODES, list(m.values)[:3]):
        print_line("fit", case, f"eps({v:.2f}), iminuit", value, "1")


main()
