// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/density_picture.hpp"

#include <algorithm>
#include <cmath>

namespace bouncelab::fit {
namespace {

std::vector<double> even_edges(double lo, double hi, std::size_t n) {
  std::vector<double> edges;
  for (std::size_t k = 0; k <= n; ++k)
    edges.push_back(lo + (hi - lo) * static_cast<double>(k) / static_cast<double>(n));
  return edges;
}

std::size_t bin_of(double x, const std::vector<double>& edges) {
  const double fraction = (x - edges.front()) / (edges.back() - edges.front());
  const auto n = edges.size() - 1;
  return std::min(static_cast<std::size_t>(fraction * static_cast<double>(n)), n - 1);
}

}  // namespace

DensityPicture density_picture(const RestitutionSamples& samples, std::size_t n_v, std::size_t n_eps) {
  DensityPicture picture;
  std::vector<double> v, eps;
  for (const RestitutionSample& s : samples) {
    if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps)) continue;
    v.push_back(s.v_mps);
    eps.push_back(s.eps);
  }
  if (v.size() < 2) return picture;
  const auto most = static_cast<std::size_t>(std::max(4.0, std::sqrt(static_cast<double>(v.size()))));
  n_v = std::min(n_v, most);
  n_eps = std::min(n_eps, most);
  const auto [v_lo, v_hi] = std::minmax_element(v.begin(), v.end());
  std::vector<double> sorted = eps;
  std::sort(sorted.begin(), sorted.end());
  const double lo = sorted[sorted.size() / 1000], hi = sorted[sorted.size() - 1 - sorted.size() / 1000];
  const double margin = std::max(0.1 * (hi - lo), 1e-9);
  picture.v_edges_mps = even_edges(*v_lo, std::max(*v_hi, *v_lo * (1.0 + 1e-9)), n_v);
  picture.eps_edges = even_edges(lo - margin, hi + margin, n_eps);
  picture.counts.assign(n_eps, std::vector<std::size_t>(n_v, 0));
  for (std::size_t k = 0; k < v.size(); ++k) {
    if (eps[k] < picture.eps_edges.front() || eps[k] > picture.eps_edges.back())
      ++picture.n_outside;
    else
      ++picture.counts[bin_of(eps[k], picture.eps_edges)][bin_of(v[k], picture.v_edges_mps)];
  }
  return picture;
}

}  // namespace bouncelab::fit
