// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/numerics.hpp"

namespace bouncelab::fit {

/// How a computation ended. What could be computed is there whatever the status.
enum class FitStatus {
  ok,
  not_identifiable,  ///< converged, but some parameter is not determined by these data (message says which)
  not_applicable,    ///< the model cannot describe such data at all
  not_converged,
  too_few_samples,
};
/// The words of fit.json: "ok", "not_identifiable", ...
const char* to_string(FitStatus status);

struct Interval {
  double lo = 0.0;
  double hi = 0.0;
};
/// [lo, hi]
Value as_value(const Interval& interval);

/// What errors rest on. Impacts of one drop share the velocity that the ball has gained sideways and by spin, so they
/// are not independent; drops are.
enum class ErrorBasis {
  independent_samples,  ///< the density of the scatter; true where samples are independent
  by_sample,            ///< leave-one-out of samples: any scatter, but samples independent
  by_drop,              ///< leave-one-drop-out: whatever goes on within a drop
};
/// The words of fit.json: "independent_samples", "by_sample", "by_drop".
const char* to_string(ErrorBasis basis);

/// With fewer drops how they differ from each other is not known well enough to judge errors by it.
inline constexpr std::size_t kFewestDrops = 10;

/// The drops that samples come from.
struct DropCount {
  std::size_t n = 0;
  ErrorBasis errors =
      ErrorBasis::independent_samples;  ///< by drop from 10 drops on, else by sample from 30 a parameter on
};
Description members_of(const DropCount*);

/// A number with its uncertainty. What is not known is absent.
struct Estimate {
  double value = 0.0;
  /// Standard error: from how the drops differ from each other where the fit says so (ErrorBasis::by_drop), else from
  /// the expected information of independent samples.
  std::optional<double> se;
  std::optional<double> se_independent;  ///< where se is by drop: what it would be if samples were independent
  std::optional<Interval> ci68;          ///< 68.27 % confidence interval, of the same basis as se
  std::optional<Interval> ci95;          ///< 95 % confidence interval
  bool identified = true;                ///< false: the data do not determine it (see the fit's message)
};
Description members_of(const Estimate*);

/// Of a sum of squares that is chi-square if what is tested holds.
struct ChiSquareTest {
  double chi2 = 0.0, ndf = 0.0, p_value = 1.0;  ///< p: probability of a larger chi2
};
Description members_of(const ChiSquareTest*);

struct NamedEstimate {
  std::string name;
  Estimate estimate;
};

/// A curve with its pointwise 95 % band.
struct CurvePoint {
  double x = 0.0;
  double y = 0.0;
  std::optional<Interval> band95;
  std::optional<double> se = std::nullopt;
};
Description members_of(const CurvePoint*);

/// Square matrix by rows.
using Matrix = std::vector<std::vector<double>>;

/// value, standard error and the intervals value -+ reach68 se, value -+ reach95 se; by default the normal ones.
Estimate normal_estimate(double value, double se, double reach68 = 1.0, double reach95 = kNormal95);

/// The same by Student's t. @param ndf  degrees of freedom by which the variance is known
Estimate student_estimate(double value, double variance, double ndf);

/// "0.98169 ± 0.00004": two digits of the standard error and as many decimals of the value; six significant digits of
/// the value where there is no standard error (absent, not positive or not finite).
std::string in_words(double value, std::optional<double> se);

}  // namespace bouncelab::fit
