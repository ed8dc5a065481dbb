// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/parallel.hpp"
#include "law/law_model.hpp"
#include "law/normal_laplace.hpp"

namespace bouncelab::fit {

// exp() of anything beyond is no scatter of a coefficient of restitution; keeps the search out of overflow
inline constexpr double kLogScaleMin = -30.0, kLogScaleMax = 3.0;

inline constexpr std::size_t kParallel = 4096;  ///< samples of one piece of parallel work, a multiple of kBlockSize

/// Density of the scatter about the curve, of scales b_below(v) and b_above(v): log b = sum_k c_k x^k,
/// x = log(v / v_ref), k < n_terms, for each side.
struct ScatterFamily {
  bool has_normal_part = true;  ///< of sqrt(b_below b_above) exp(rho)
  std::size_t n_terms = 3;
  double v_ref_mps = 1.0;
  double lost_share = 0.0;  ///< of bounces whose eps may be anything from 0 to 2
  std::optional<double> log_size =
      std::nullopt;  ///< log b at v_ref by a first look: the prior that keeps the scale from 0
  /// Scales are those of a rough ball released at rest, q times what LawData has of each impact's place in its drop.
  bool by_place = false;
  Eigen::Index n_parameters() const { return static_cast<Eigen::Index>(2 * n_terms + (has_normal_part ? 1 : 0)); }
};

/// Some samples: what is computed of them on the way to their likelihood.
struct SampleBlock {
  std::size_t begin = 0, n = 0;  ///< successive ones from begin on
  Block residual;                ///< from the curve; with a normal part from where the exponentials join
  Block slope;                   ///< of the curve by q, where the model is not linear: one parameter
  SidesBlock sides;
  Block tau, inverse_tau;                      ///< normal part and timing error together
  Block normal_share, size;                    ///< of the normal part in tau^2; sqrt(b_below b_above)
  Block peak, peak_by_asymmetry, peak_by_rho;  ///< in units of size
  DensityBlock f;
};

/// Log-likelihood of the curve and the scatter together: theta = (q, c_below, c_above[, rho]).
///
/// The law is the density's peak, of the scatter alone without the timing errors (mode_offset): with two exponentials
/// where they join, where the scatter is symmetric also its mean.
///
/// Weak priors decide where the samples do not:
/// - the sides' ratio, d_k = c_above,k - c_below,k: normal about 0 with standard deviation 2^-(k+1/2), so a factor 2 at
///   v_ref, and varying slowly with speed;
/// - rho: normal about 0 with standard deviation 2, a factor 7 either way;
/// - the scale's size, where there was a first look: b^2 as from n samples and one more of that look. Without it the
///   likelihood has no bound: a curve through some samples, all others lost. Source: Chen, Tan & Zhang, Statistica
///   Sinica 18, 443 (2008).
class LawLikelihood {
 public:
  LawLikelihood(const LawData& data, const LawModel& model, const ScatterFamily& scatter);

  Eigen::Index n_parameters() const { return n_law_ + scatter_.n_parameters(); }
  double operator()(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const;

  /// Expected information at theta; from every n-th sample (in order of speed) where there are many.
  Eigen::MatrixXd information(const Eigen::VectorXd& theta) const;

  /// Of each sample to be a lost bounce, not one of the scatter.
  std::vector<double> probabilities_of_lost(const Eigen::VectorXd& theta) const;
  /// Distribution function of the scatter at each sample.
  std::vector<double> probabilities_below(const Eigen::VectorXd& theta) const;
  /// Of each sample its distance from the curve, and the derivative of its log density by the curve's location.
  struct LocationScores {
    std::vector<double> residual, score;
  };
  LocationScores location_scores(const Eigen::VectorXd& theta) const;
  /// Expected information of sample k on location, log b_below, log b_above and rho.
  Eigen::Matrix4d information_of(const Eigen::VectorXd& theta, std::size_t k) const {
    return information_of(theta, shape(theta), k);
  }
  /// Gradients of each drop's log-likelihood, a column a drop.
  Eigen::MatrixXd scores_by_drop(const Eigen::VectorXd& theta) const;
  Eigen::MatrixXd scores_by_sample(const Eigen::VectorXd& theta) const;
  /// Expected information of each drop, without the penalty; that of a sample taken from the nearest of those that
  /// information() is made of.
  std::vector<Eigen::MatrixXd> information_by_drop(const Eigen::VectorXd& theta) const;
  std::size_t n_drops() const;
  ScatterModel scatter_model(const Eigen::VectorXd& theta) const;
  /// b_below and b_above of sample k.
  std::pair<double, double> sides_of(const Eigen::VectorXd& theta, std::size_t k) const;

  const LawData& data() const { return data_; }
  const LawModel& model() const { return model_; }
  const ScatterFamily& scatter() const { return scatter_; }

 private:
  /// What the scatter of all samples has in common at one theta.
  struct Shape {
    double square_of_ratio = 0.0;   ///< of the normal part over sqrt(b_below b_above)
    std::vector<ModeOffset> peaks;  ///< at knots of log speed; one where it does not depend on the speed
  };
  Shape shape(const Eigen::VectorXd& theta) const;
  double square_of_normal_ratio(const Eigen::VectorXd& theta) const;
  /// Of s.n samples from s.begin on: densities with their derivatives.
  void compute(const Eigen::VectorXd& theta, const Shape& shape, SampleBlock& s) const;
  /// All that density and distribution function take: residuals (with a normal part from where the exponentials join),
  /// sides, standard deviations of normal part and timing error together.
  void compute_scatter(const Eigen::VectorXd& theta, const Shape& shape, SampleBlock& s) const;
  /// Calls visit(samples) for the blocks of samples of one part; threads share the parts.
  template <class Visit>
  void visit_part(std::size_t part, const Visit& visit) const {
    SampleBlock s;
    const std::size_t end = std::min(data_.size(), (part + 1) * kParallel);
    for (s.begin = part * kParallel; s.begin < end; s.begin += s.n) {
      s.n = std::min(kBlockSize, end - s.begin);
      visit(s);
    }
  }
  std::size_t n_parts() const { return (data_.size() + kParallel - 1) / kParallel; }
  template <class Visit>
  void visit_all(const Visit& visit) const {
    parallel_for(n_parts(), 0, [&](std::size_t part) { visit_part(part, visit); });
  }
  /// The curve's derivatives by q at the samples of a block.
  const double* slope_of(const SampleBlock& s, std::size_t i) const {
    return model_.is_linear() ? &basis_(static_cast<Eigen::Index>(s.begin), static_cast<Eigen::Index>(i))
                              : s.slope.data();
  }
  void compute_curve(const Eigen::VectorXd& theta, SampleBlock& s) const;
  void compute_sides(const Eigen::VectorXd& theta, SampleBlock& s) const;
  void compute_peaks(const Shape& shape, SampleBlock& s) const;
  void add_scores(SampleBlock& s, double* sums) const;
  double precision_of_asymmetry(Eigen::Index k) const;
  double penalty(const Eigen::VectorXd& theta, Eigen::VectorXd* gradient) const;
  void add_penalty_curvature(const Eigen::VectorXd& theta, Eigen::MatrixXd& information) const;
  Eigen::Matrix4d information_of(const Eigen::VectorXd& theta, const Shape& shape, std::size_t k) const;
  /// Derivatives of sample k's location, log b_below, log b_above and rho by theta.
  using Design = Eigen::Matrix<double, 4, Eigen::Dynamic>;
  Design design(const Eigen::VectorXd& theta, std::size_t k) const;
  std::size_t information_stride() const;

  const LawData& data_;
  const LawModel& model_;
  ScatterFamily scatter_;
  Eigen::Index n_law_;
  double odds_of_lost_density_ = 0.0;  ///< the density of lost bounces against the share of those that are not
  std::vector<double> x_;              ///< log(v / v_ref)
  Eigen::MatrixXd of_places_;          ///< by_place: columns of powers of x that follow log b_below/q, log b_above/q
  double knot_distance_ = 1.0;         ///< in x
  Eigen::MatrixXd basis_;              ///< a row a sample
};

/// Without the normal part's size. @param n_law  parameters of the law, which come first in theta
ScatterModel scatter_model_of(const Eigen::VectorXd& theta, Eigen::Index n_law, const ScatterFamily& scatter);

}  // namespace bouncelab::fit
