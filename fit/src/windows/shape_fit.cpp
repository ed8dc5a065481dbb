// SPDX-License-Identifier: GPL-3.0-or-later
#include "windows/window_fit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>

#include "bouncelab/core/elementary.hpp"
#include "law/goodness.hpp"
#include "law/normal_laplace.hpp"
#include "numerics/distributions.hpp"
#include "numerics/linalg.hpp"
#include "numerics/maximise.hpp"

namespace bouncelab::fit {
namespace {

constexpr Eigen::Index kCellsPerBin = 4;

/// Cells of equal width, four to a bin, and the timing errors that move what is in them.
class Blur {
 public:
  Blur(const Bins& bins, std::vector<double> tau) : n_bins_(static_cast<Eigen::Index>(bins.counts.size())) {
    width_ = (bins.eps_edges.back() - bins.eps_edges.front()) / static_cast<double>(n_bins_ * kCellsPerBin);
    std::sort(tau.begin(), tau.end());
    margin_ = static_cast<Eigen::Index>(std::min(6.0 * tau.back() / width_ + 1.0, 2000.0));
    lo_ = bins.eps_edges.front() - static_cast<double>(margin_) * width_;
    n_cells_ = n_bins_ * kCellsPerBin + 2 * margin_;
    // by how many cells an edge lies above a cell's lower end, less n_cells: shares of the cell's content that end up
    // below the edge, above it, and within the bin that begins there. Each by what is small: tails stay exact.
    const Eigen::Index n = 2 * n_cells_ + 1 + kCellsPerBin;
    below_ = above_ = Eigen::VectorXd::Zero(n);
    const std::size_t n_classes = std::min<std::size_t>(16, tau.size());
    for (std::size_t j = 0; j < n_classes; ++j) {
      const double t = tau[(2 * j + 1) * tau.size() / (2 * n_classes)];
      Eigen::VectorXd below(n), above(n);
      for (Eigen::Index k = 0; k < n; ++k) below[k] = (static_cast<double>(k - n_cells_) - 0.5) * width_ / t;
      above = -below;
      normal_cdf_each({below.data(), static_cast<std::size_t>(n)});
      normal_cdf_each({above.data(), static_cast<std::size_t>(n)});
      below_ += below / static_cast<double>(n_classes);
      above_ += above / static_cast<double>(n_classes);
    }
    within_.resize(n - kCellsPerBin);
    for (Eigen::Index k = 0; k < within_.size(); ++k)
      within_[k] = k < n_cells_ ? below_[k + kCellsPerBin] - below_[k] : above_[k] - above_[k + kCellsPerBin];
  }

  Eigen::Index n_cells() const { return n_cells_; }
  double edge(Eigen::Index cell) const { return lo_ + static_cast<double>(cell) * width_; }

  /// Probabilities of underflow, bins, overflow. @param cells  of: below the cells, each cell, above them
  Eigen::VectorXd bins_of(const Eigen::VectorXd& cells) const {
    const auto inner = cells.segment(1, n_cells_);
    const auto moved = [&](const Eigen::VectorXd& share, Eigen::Index bin) {
      return inner.dot(share.segment(margin_ + bin * kCellsPerBin + 1, n_cells_).reverse());
    };
    Eigen::VectorXd p(n_bins_ + 2);
    p[0] = cells[0] + moved(below_, 0);
    for (Eigen::Index k = 0; k < n_bins_; ++k) p[k + 1] = moved(within_, k);
    p[n_bins_ + 1] = cells[n_cells_ + 1] + moved(above_, n_bins_);
    return p.cwiseMax(1e-290);
  }

 private:
  Eigen::Index n_bins_, margin_ = 0, n_cells_ = 0;
  double width_ = 0.0, lo_ = 0.0;
  Eigen::VectorXd below_, above_, within_;
};

/// A shape: parameters of the search are its location, then logarithms of widths.
struct ShapeModel {
  DensityShape shape;
  Eigen::VectorXd start;
  /// Probability below the cells, of each cell, and above them.
  Eigen::VectorXd (*cells)(const Eigen::VectorXd& theta, const Blur& blur);
  std::vector<std::string> parameter_names;
  double exponent;  ///< of widths as they are reported; -1: as slopes
};

/// Probabilities on either side of the edges.
struct Sides {
  Eigen::ArrayXd below, above;
};

Eigen::ArrayXd edges_of(const Blur& blur) {
  Eigen::ArrayXd edges(blur.n_cells() + 1);
  for (Eigen::Index i = 0; i < edges.size(); ++i) edges[i] = blur.edge(i);
  return edges;
}

std::span<double> span_of(Eigen::ArrayXd& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }
Eigen::ArrayXd exp_of(Eigen::ArrayXd x) {
  exp_each(span_of(x));
  return x;
}
Eigen::ArrayXd normal_cdf_of(Eigen::ArrayXd z) {
  normal_cdf_each(span_of(z));
  return z;
}

/// Differences of whichever side is the smaller.
Eigen::VectorXd cells_of(const Sides& s) {
  const Eigen::Index n = s.below.size() - 1;
  Eigen::VectorXd cells(n + 2);
  cells[0] = s.below[0];
  for (Eigen::Index i = 0; i < n; ++i)
    cells[i + 1] = s.below[i] < s.above[i] ? s.below[i + 1] - s.below[i] : s.above[i] - s.above[i + 1];
  cells[n + 1] = s.above[n];
  return cells;
}

Eigen::VectorXd two_exponentials(const Eigen::VectorXd& x, const Blur& blur) {
  const double below = exp(x[1]), above = exp(x[2]), p_above = above / (below + above);
  const Eigen::ArrayXd d = edges_of(blur) - x[0];
  const Eigen::ArrayXd tail = exp_of((d > 0.0).select(-d / above, d / below)) *
                              (d > 0.0).select(Eigen::ArrayXd::Constant(d.size(), p_above), 1.0 - p_above);
  return cells_of({(d > 0.0).select(1.0 - tail, tail), (d > 0.0).select(tail, 1.0 - tail)});
}

Eigen::VectorXd normal(const Eigen::VectorXd& x, const Blur& blur) {
  const Eigen::ArrayXd z = (edges_of(blur) - x[0]) / exp(x[1]);
  return cells_of({normal_cdf_of(z), normal_cdf_of(-z)});
}

std::vector<ShapeModel> shape_models(const ShapeStart& s) {
  const Eigen::Vector3d sides(s.peak, log(s.b_below), log(s.b_above));
  const Eigen::Vector2d mean_and_sd(s.peak + s.b_above - s.b_below, log(hypot(s.b_below, s.b_above)));
  return {
      {DensityShape::two_exponentials, sides, two_exponentials, {"peak_eps", "slope_rising", "slope_falling"}, -1.0},
      {DensityShape::normal, mean_and_sd, normal, {"mean", "sd"}, 1.0}};
}

/// Multinomial log-likelihood of the bins' counts, its gradient by differences, its information.
struct BinnedLikelihood {
  const ShapeModel& model;
  const Blur& blur;
  const Eigen::VectorXd& counts;

  Eigen::MatrixXd derivatives(const Eigen::VectorXd& x) const {
    Eigen::MatrixXd d(counts.size(), x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      Eigen::VectorXd ahead = x, behind = x;
      const double h = i == 0 ? 1e-4 * exp(x[1]) : 1e-4;
      ahead[i] += h;
      behind[i] -= h;
      d.col(i) = (blur.bins_of(model.cells(ahead, blur)) - blur.bins_of(model.cells(behind, blur))) / (2.0 * h);
    }
    return d;
  }
  double operator()(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) const {
    if (!x.allFinite()) return -HUGE_VAL;
    const Eigen::VectorXd p = blur.bins_of(model.cells(x, blur));
    if (gradient) *gradient = transposed_product(derivatives(x), counts.cwiseQuotient(p));
    return counts.dot(p.unaryExpr([](double share) { return log(share); }));
  }
  Eigen::MatrixXd information(const Eigen::VectorXd& x) const {
    const Eigen::VectorXd p = blur.bins_of(model.cells(x, blur));
    const Eigen::MatrixXd d = derivatives(x);
    return counts.sum() * transposed_product(d, p.cwiseMax(1e-12).cwiseInverse().asDiagonal() * d);
  }
  /// The same from the counts found: a metric for the search also where the shape is far from them.
  Eigen::MatrixXd observed_information(const Eigen::VectorXd& x) const {
    const Eigen::VectorXd p = blur.bins_of(model.cells(x, blur));
    const Eigen::MatrixXd d = p.cwiseInverse().asDiagonal() * derivatives(x);
    return transposed_product(d, counts.asDiagonal() * d);
  }
};

void set_chi2(ShapeFit& fit, const Eigen::VectorXd& expected, const Eigen::VectorXd& counts) {
  constexpr double kFewest = 5.0;
  double e = 0.0, n = 0.0, chi2 = 0.0, last_e = 0.0, last_n = 0.0;
  std::size_t n_groups = 0;
  for (Eigen::Index k = 0; k < counts.size(); ++k) {
    e += expected[k];
    n += counts[k];
    if (e < kFewest) continue;
    chi2 += (n - e) * (n - e) / e;
    ++n_groups;
    last_e = e;
    last_n = n;
    e = n = 0.0;
  }
  if (n_groups < fit.parameters.size() + 2) return;
  // what is left over joins the last group
  chi2 += (n + last_n - e - last_e) * (n + last_n - e - last_e) / (e + last_e) -
          (last_n - last_e) * (last_n - last_e) / last_e;
  fit.chi2 = chi2;
  fit.ndf = n_groups - 1 - fit.parameters.size();
  fit.p_value = chi2_survival(chi2, static_cast<double>(*fit.ndf));
}

ShapeFit fit_shape(const ShapeModel& model, const Blur& blur, const Eigen::VectorXd& counts) {
  const BinnedLikelihood likelihood{model, blur, counts};
  const auto function = [&](const Eigen::VectorXd& x, Eigen::VectorXd* g) { return likelihood(x, g); };
  Maximum maximum = maximise(function, model.start, likelihood.observed_information(model.start));
  for (int i = 0; i < 4 && !maximum.converged; ++i)
    maximum = maximise(function, maximum.x, likelihood.observed_information(maximum.x));
  ShapeFit fit;
  fit.shape = model.shape;
  fit.status = maximum.converged ? FitStatus::ok : FitStatus::not_converged;
  fit.loglik = maximum.loglik;
  const Eigen::MatrixXd white = whitening(likelihood.information(maximum.x), 1e-10);
  const Eigen::VectorXd se = gram(white).diagonal().cwiseSqrt();
  fit.parameters.push_back({model.parameter_names[0], normal_estimate(maximum.x[0], se[0])});
  for (Eigen::Index i = 1; i < maximum.x.size(); ++i) {
    const auto j = static_cast<std::size_t>(i);
    const double value = exp(model.exponent * maximum.x[i]);
    fit.parameters.push_back({model.parameter_names[j], normal_estimate(value, value * se[i])});
  }
  const Eigen::VectorXd expected = counts.sum() * blur.bins_of(model.cells(maximum.x, blur));
  set_chi2(fit, expected, counts);
  fit.expected.assign(expected.begin() + 1, expected.end() - 1);
  return fit;
}

}  // namespace

std::vector<ShapeFit> fit_shapes(const Bins& bins, const std::vector<double>& tau, const ShapeStart& start) {
  const Blur blur(bins, tau);
  Eigen::VectorXd counts(static_cast<Eigen::Index>(bins.counts.size()) + 2);
  counts[0] = static_cast<double>(bins.underflow);
  std::transform(bins.counts.begin(), bins.counts.end(), counts.begin() + 1,
                 [](std::size_t n) { return static_cast<double>(n); });
  counts[counts.size() - 1] = static_cast<double>(bins.overflow);
  std::vector<ShapeFit> fits;
  for (const ShapeModel& model : shape_models(start)) fits.push_back(fit_shape(model, blur, counts));
  const auto aic = [](const ShapeFit& f) { return 2.0 * static_cast<double>(f.parameters.size()) - 2.0 * f.loglik; };
  const double reference = aic(fits.front());
  for (ShapeFit& fit : fits) fit.delta_aic = aic(fit) - reference;
  return fits;
}

}  // namespace bouncelab::fit
