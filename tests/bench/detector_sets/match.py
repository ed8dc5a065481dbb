# SPDX-License-Identifier: GPL-3.0-or-later
"""Found times against true ones: pairs one to one about one common offset, and what the stated errors are worth."""
import numpy as np


def pairs(truth, found, tolerance_s, offset_s=0.0):
    """Indices (true, found), nearest first, one to one."""
    near = [(abs(found[j] - offset_s - truth[i]), i, j) for i in range(len(truth))
            for j in range(np.searchsorted(found, truth[i] + offset_s - tolerance_s), np.searchsorted(found, truth[i] + offset_s + tolerance_s, "right"))]
    used_true, used_found, kept = set(), set(), []
    for _, i, j in sorted(near):
        if i not in used_true and j not in used_found:
            used_true.add(i), used_found.add(j), kept.append((i, j))
    return np.array(sorted(kept), int).reshape(-1, 2).T


def n_near(truth, found, tolerance_s):
    k = np.clip(np.searchsorted(found, truth), 1, len(found) - 1) if len(found) > 1 else np.zeros(len(truth), int)
    return int(np.sum(np.minimum(np.abs(found[k] - truth), np.abs(found[k - 1] - truth)) <= tolerance_s))


def common_offset(truth, found, tolerance_s, reach_s=5e-3):
    """The offset within +-reach at which most true times are found; of equally good ones that nearest to 0."""
    if not len(found) or not len(truth):
        return 0.0
    grid = np.arange(-reach_s, reach_s, 2.5e-4)
    score = np.array([n_near(truth, found - offset, tolerance_s) for offset in grid]) - np.abs(grid)
    return float(grid[np.argmax(score)])


def matched(truth, found, tolerance_s, reach_s=5e-3):
    """(indices of true, indices of found, offset): the common offset is refined to the median of the pairs."""
    offset = common_offset(truth, found, tolerance_s, reach_s)
    i, j = pairs(truth, found, tolerance_s, offset)
    if len(i) > 2 and abs(np.median(found[j] - truth[i])) < reach_s:
        refined = float(np.median(found[j] - truth[i]))
        other = pairs(truth, found, tolerance_s, refined)
        if other.shape[1] >= len(i):
            return other[0], other[1], refined
    return i, j, offset


def interval_pulls(truth, found, sigma_s, clear, i, j, longest_s=0.5):
    """Errors of intervals between neighbours that are both found and clear, over their stated errors."""
    if len(i) < 2:
        return np.zeros(0)
    error = found[j] - truth[i]
    use = (np.diff(i) == 1) & clear[j][1:] & clear[j][:-1] & (np.diff(truth[i]) < longest_s)
    pull = np.diff(error) / np.hypot(sigma_s[j][1:], sigma_s[j][:-1])
    return pull[use & np.isfinite(pull)]


def eps_pulls(truth, drop, found, sigma_s, i, j):
    """Errors of eps = T_(k+1) / T_k over what the stated errors of three independent impacts give."""
    at = np.full(len(truth), np.nan)
    sigma = np.full(len(truth), np.nan)
    at[i], sigma[i] = found[j], sigma_s[j]
    first, second = at[1:-1] - at[:-2], at[2:] - at[1:-1]
    eps = second / first
    true = (truth[2:] - truth[1:-1]) / (truth[1:-1] - truth[:-2])
    spread = np.sqrt(sigma[2:]**2 + (1 + eps)**2 * sigma[1:-1]**2 + eps**2 * sigma[:-2]**2) / np.abs(first)
    pull = ((eps - true) / spread)[drop[2:] == drop[:-2]]
    return pull[np.isfinite(pull)]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else float("nan")
