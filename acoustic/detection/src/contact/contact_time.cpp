// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/contact_time.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

// A half-sine pulse of duration tau has the rms frequency 1/(2 tau). What is struck, the room and the microphone pass
// the higher frequencies better or worse: of steel, wood and rubber from 30 us to 6 ms, tau f is between 0.1 and 0.8.
constexpr double kDurationTimesFrequency = 0.4;
constexpr double kDurationSigma = 0.25;  // times the frequency
constexpr double kMaxDifference = 3.0;  // standard errors between the prior and a recording, beyond which it is dropped
constexpr double kSignificant = 2.0;    // standard errors of tau^2: four of tau
// standard errors by which two pulses must differ before it counts: neighbouring bands are correlated
constexpr double kMinPulseDifference = 2.0;

ContactFit pool(const std::vector<ContactEvidence>& drops, ContactFit ContactEvidence::*pulse) {
  ContactFit pooled;
  double weights = 0.0;
  for (const ContactEvidence& drop : drops) {
    const ContactFit& fit = drop.*pulse;
    const double weight = 1.0 / (fit.sigma2_s2 * fit.sigma2_s2);
    weights += weight;
    pooled.tau2_s2 += weight * fit.tau2_s2;
  }
  pooled.tau2_s2 /= weights;
  double chi2 = 0.0;
  for (const ContactEvidence& drop : drops)
    chi2 += square(((drop.*pulse).tau2_s2 - pooled.tau2_s2) / (drop.*pulse).sigma2_s2);
  const double scatter = drops.size() > 1 ? std::max(1.0, chi2 / static_cast<double>(drops.size() - 1)) : 1.0;
  pooled.sigma2_s2 = std::sqrt(scatter / weights);
  return pooled;
}

/// Probability that Hertz's pulse is the more likely one, by a paired test of the log-likelihoods over bands: a band
/// that neither pulse explains counts once, whatever the number of impacts.
double probability_of_hertz(const std::vector<ContactEvidence>& drops) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const ContactEvidence& drop : drops)
    for (std::size_t m = 0; m < drop.hertz.log_likelihood.size(); ++m) {
      const double more = drop.hertz.log_likelihood[m] - drop.half_sine.log_likelihood[m];
      n += 1.0, sum += more, squares += more * more;
    }
  const double error = std::sqrt(std::max(squares - sum * sum / n, 1e-30) / (n - 1.0) * n);
  const double z = sum / error;
  return 0.5 * erfc(-std::copysign(std::max(0.0, std::abs(z) - kMinPulseDifference), z) / std::sqrt(2.0));
}

/// Combined with the prior, where the two are compatible.
ContactFit with_prior(ContactFit fit, const ContactLaw& assumed) {
  const double prior = square(assumed.tau_1_s);
  const double spread = 2.0 * assumed.tau_1_s * assumed.sigma_s;
  if (std::abs(fit.tau2_s2 - prior) > kMaxDifference * hypot(fit.sigma2_s2, spread)) return fit;
  const double weight = 1.0 / (fit.sigma2_s2 * fit.sigma2_s2);
  const double prior_weight = 1.0 / (spread * spread);
  fit.tau2_s2 = (weight * fit.tau2_s2 + prior_weight * prior) / (weight + prior_weight);
  fit.sigma2_s2 = std::sqrt(1.0 / (weight + prior_weight));
  return fit;
}

/// tau_1 from its square; 0 where that is negative.
ContactLaw law_of(const ContactFit& fit) {
  const double square = std::max(fit.tau2_s2, 0.0);
  return {std::sqrt(square), std::sqrt(square + fit.sigma2_s2) - std::sqrt(square)};
}

}  // namespace

double contact_delay(double v_mps, double reference_scaling) { return 0.5 * (pow(v_mps, -0.2) - reference_scaling); }

ContactLaw assumed_contact(double rms_hz) {
  const double tau_s = kDurationTimesFrequency / rms_hz;
  return {tau_s, kDurationSigma / rms_hz, tau_s};
}

std::optional<ContactLaw> pool_contacts(const std::vector<ContactEvidence>& drops, const ContactLaw& assumed) {
  if (drops.empty()) return std::nullopt;
  const ContactFit pooled[] = {pool(drops, &ContactEvidence::hertz), pool(drops, &ContactEvidence::half_sine)};
  const ContactLaw a = law_of(with_prior(pooled[0], assumed));
  const ContactLaw b = law_of(with_prior(pooled[1], assumed));
  const double p_hertz = probability_of_hertz(drops);
  ContactLaw law;
  law.tau_1_s = p_hertz * a.tau_1_s + (1.0 - p_hertz) * b.tau_1_s;
  law.sigma_s = std::sqrt(p_hertz * a.sigma_s * a.sigma_s + (1.0 - p_hertz) * b.sigma_s * b.sigma_s +
                          p_hertz * (1.0 - p_hertz) * square(a.tau_1_s - b.tau_1_s));
  law.hertz_tau_1_s = a.tau_1_s;
  law.is_significant = pooled[0].tau2_s2 > kSignificant * pooled[0].sigma2_s2;
  return law;
}

}  // namespace bouncelab::detection
