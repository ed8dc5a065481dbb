// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "law/law_likelihood.hpp"

// Second derivatives of the log-likelihood, sample by sample.

namespace bouncelab::fit {
namespace {

constexpr std::size_t kMostQuantities = 4;  // location, log b_below, log b_above, rho
using Scores = std::array<Block, kMostQuantities>;

}  // namespace

/// theta a step ahead and behind along each quantity that a sample's density depends on.
struct LawLikelihood::Displaced {
  struct Place {
    Eigen::VectorXd theta;
    Shape shape;
    double location = 0.0;  ///< as in compute()
  };
  struct Pair {
    Place ahead, behind;
    double factor = 0.0;  ///< from the scores' difference, behind less ahead, to their derivative, sign reversed
  };
  std::vector<Pair> quantities;
};

LawLikelihood::Displaced LawLikelihood::displaced(const Eigen::VectorXd& theta) const {
  const double n = static_cast<double>(data_.size());
  const auto n_terms = static_cast<Eigen::Index>(scatter_.n_terms);
  Displaced result;
  const double of_curve = std::sqrt(static_cast<double>(n_law_) / n);
  const Shape here = shape(theta);
  result.quantities.push_back({{theta, here, of_curve}, {theta, here, -of_curve}, 0.5 / of_curve});
  std::vector<Eigen::Index> parameters{n_law_};
  if (scatter_.is_two_sided()) parameters.push_back(n_law_ + n_terms);
  if (scatter_.kind == ScatterKind::normal_laplace) parameters.push_back(theta.size() - 1);
  const double of_scale = std::sqrt(static_cast<double>(n_terms) / n);
  for (const Eigen::Index i : parameters) {
    Eigen::VectorXd ahead = theta, behind = theta;
    ahead[i] += of_scale;
    behind[i] -= of_scale;
    result.quantities.push_back({{ahead, shape(ahead), 0.0}, {behind, shape(behind), 0.0}, 0.5 / of_scale});
  }
  return result;
}

/// Sums over samples of their second derivatives by pairs of quantities times the parameters' weights in both.
class LawLikelihood::CurvatureSum {
 public:
  CurvatureSum(const LawLikelihood& likelihood, const Displaced& displaced)
      : likelihood_(likelihood),
        displaced_(displaced),
        n_law_(static_cast<std::size_t>(likelihood.n_law_)),
        n_terms_(displaced.quantities.size(), likelihood.scatter_.n_terms),
        sums_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n_sums(likelihood)))) {
    if (likelihood.scatter_.kind == ScatterKind::normal_laplace) n_terms_.back() = 1;
  }

  static std::size_t n_sums(const LawLikelihood& likelihood) {
    // of the law's pairs, of the law with powers of x, of powers of x by pairs of quantities
    const auto n_law = static_cast<std::size_t>(likelihood.n_law_);
    const std::size_t n_terms = likelihood.scatter_.n_terms, n_scales = kMostQuantities - 1;
    return n_law * (n_law + 1) / 2 + n_scales * n_law * n_terms + n_scales * (n_scales + 1) / 2 * 2 * n_terms + 1;
  }

  void add(SampleBlock& s) {
    const std::size_t n = s.n;
    std::array<Scores, kMostQuantities> by;  // by[q][i]: of score i by quantity q
    Block width;
    for (std::size_t q = 0; q < displaced_.quantities.size(); ++q) {
      const Displaced::Pair& pair = displaced_.quantities[q];
      Scores behind;
      likelihood_.compute(pair.behind.theta, pair.behind.shape, s, pair.behind.location);
      for (std::size_t i = 0; i < displaced_.quantities.size(); ++i) behind[i] = score(s, i);
      likelihood_.compute(pair.ahead.theta, pair.ahead.shape, s, pair.ahead.location);
      for (std::size_t i = 0; i < displaced_.quantities.size(); ++i) {
        const Block& ahead = score(s, i);
        for (std::size_t k = 0; k < n; ++k) by[q][i][k] = (behind[i][k] - ahead[k]) * pair.factor;
      }
      if (q == 0) width = s.width;
    }
    for (std::size_t i = 0; i < displaced_.quantities.size(); ++i)
      for (std::size_t k = 0; k < n; ++k) by[0][i][k] /= width[k];
    Eigen::Index kind = 0;
    for (std::size_t q = 0; q < displaced_.quantities.size(); ++q)
      for (std::size_t i = 0; i <= q; ++i) {
        for (std::size_t k = 0; k < n; ++k) by[q][i][k] = 0.5 * (by[q][i][k] + by[i][q][k]);
        kind = add_pair(q, i, by[q][i], s, kind);
      }
  }

  const Eigen::VectorXd& sums() const { return sums_; }

  /// The matrix that sums of add() make.
  Eigen::MatrixXd expanded(const double* sums) const {
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(likelihood_.n_parameters(), likelihood_.n_parameters());
    const auto set = [&](std::size_t i, std::size_t j, double value) {
      h(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = value;
      h(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) = value;
    };
    for (std::size_t q = 0; q < displaced_.quantities.size(); ++q)
      for (std::size_t i = 0; i <= q; ++i) {
        if (q == 0) {
          for (std::size_t a = 0; a < n_law_; ++a)
            for (std::size_t b = 0; b <= a; ++b) set(a, b, *sums++);
        } else if (i == 0) {
          for (std::size_t a = 0; a < n_law_; ++a)
            for (std::size_t k = 0; k < n_terms_[q]; ++k) set(a, first_of(q) + k, *sums++);
        } else {
          for (std::size_t k = 0; k < n_terms_[q]; ++k)
            for (std::size_t l = 0; l < n_terms_[i]; ++l) set(first_of(q) + k, first_of(i) + l, sums[k + l]);
          sums += n_terms_[q] + n_terms_[i] - 1;
        }
      }
    return h;
  }

 private:
  std::size_t first_of(std::size_t quantity) const { return n_law_ + (quantity - 1) * likelihood_.scatter_.n_terms; }

  /// By location, by log b_below (of equal sides by both), by log b_above, by rho.
  Block& score(SampleBlock& s, std::size_t i) const {
    if (i == 0) return s.f.d_location;
    if (i == 1) {
      if (!likelihood_.scatter_.is_two_sided())
        for (std::size_t k = 0; k < s.n; ++k) s.f.d_log_below[k] += s.f.d_log_above[k];
      return s.f.d_log_below;
    }
    return i == 2 ? s.f.d_log_above : s.f.d_log_tau;
  }

  /// @return the number of the next sum
  Eigen::Index add_pair(std::size_t q, std::size_t i, const Block& curvature, const SampleBlock& s, Eigen::Index kind) {
    const double* x = &likelihood_.x_[s.begin];
    if (i > 0) {
      const std::size_t n_powers = n_terms_[q] + n_terms_[i] - 1;
      add_powers(s.n, curvature.data(), x, n_powers, &sums_[kind]);
      return kind + static_cast<Eigen::Index>(n_powers);
    }
    for (std::size_t a = 0; a < n_law_; ++a) {
      Block weighted;
      const double* const slope = likelihood_.slope_of(s, a);
      for (std::size_t k = 0; k < s.n; ++k) weighted[k] = curvature[k] * slope[k];
      if (q == 0) {
        for (std::size_t b = 0; b <= a; ++b)
          sums_[kind++] += sum_of_products(s.n, weighted.data(), likelihood_.slope_of(s, b));
      } else {
        add_powers(s.n, weighted.data(), x, n_terms_[q], &sums_[kind]);
        kind += static_cast<Eigen::Index>(n_terms_[q]);
      }
    }
    return kind;
  }

  const LawLikelihood& likelihood_;
  const Displaced& displaced_;
  std::size_t n_law_;
  std::vector<std::size_t> n_terms_;  ///< by quantity
  Eigen::VectorXd sums_;
};

double LawLikelihood::bend_of_curve(const Eigen::VectorXd& theta) const {
  if (model_.is_linear()) return 0.0;
  constexpr double kStep = 1e-3;  // of log gamma: the slopes' difference is good to 1e-6
  const Derivatives here = derivatives(theta);
  const double ahead = exp(0.5 * (theta[0] + kStep)), behind = exp(0.5 * (theta[0] - kStep));
  double sum = 0.0;
  for (std::size_t k = 0; k < data_.size(); ++k) {
    const double x = basis_(static_cast<Eigen::Index>(k), 0);
    const double difference = viscoelastic_and_slope(ahead * x).second - viscoelastic_and_slope(behind * x).second;
    sum += here.by_location[k] * difference / (2.0 * kStep);
  }
  return sum;
}

Eigen::MatrixXd LawLikelihood::observed_information(const Eigen::VectorXd& theta) const {
  const Displaced places = displaced(theta);
  std::vector<Eigen::VectorXd> sums(n_parts());
  parallel_for(n_parts(), 0, [&](std::size_t part) {
    CurvatureSum sum(*this, places);
    visit_part(part, [&](SampleBlock& s) { sum.add(s); });
    sums[part] = sum.sums();
  });
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(sums.front().size());
  for (const Eigen::VectorXd& of_part : sums) sum += of_part;
  Eigen::MatrixXd h = CurvatureSum(*this, places).expanded(sum.data());
  if (!model_.is_linear()) h(0, 0) -= bend_of_curve(theta);
  add_penalty_curvature(theta, h);
  return h;
}

}  // namespace bouncelab::fit
