// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/contact_time.hpp"

#include <algorithm>
#include <cmath>

namespace bouncelab::detection {
namespace {

// what is known of any ball that rings a plate before it is heard: steel balls of 1 to 10 mm radius (Hertz); sounds
// that say otherwise by three standard errors are believed
constexpr double kUsual_s = 35e-6;
constexpr double kUsualSpread_s = 20e-6;
constexpr double kContradiction = 3.0;
constexpr double kSoft_hz = 3e3;  // a tenth of a cycle in the usual duration: steel would ring higher modes too
constexpr double kCertain = 2.0;  // standard errors of tau^2: four of tau
// standard errors by which two pulses must differ before it counts: neighbouring bands share what neither explains
constexpr double kDoubt = 2.0;

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
    chi2 += std::pow(((drop.*pulse).tau2_s2 - pooled.tau2_s2) / (drop.*pulse).sigma2_s2, 2);
  const double scatter = drops.size() > 1 ? std::max(1.0, chi2 / static_cast<double>(drops.size() - 1)) : 1.0;
  pooled.sigma2_s2 = std::sqrt(scatter / weights);
  return pooled;
}

/// How probable it is that Hertz's pulse is the more likely one over all bands, were others drawn: a band that no pulse
/// explains speaks as one, however many impacts it was heard in.
double share_of_hertz(const std::vector<ContactEvidence>& drops) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const ContactEvidence& drop : drops)
    for (std::size_t m = 0; m < drop.hertz.log_likelihood.size(); ++m) {
      const double more = drop.hertz.log_likelihood[m] - drop.half_sine.log_likelihood[m];
      n += 1.0, sum += more, squares += more * more;
    }
  const double error = std::sqrt(std::max(squares - sum * sum / n, 1e-30) / (n - 1.0) * n);
  const double z = sum / error;
  return 0.5 * std::erfc(-std::copysign(std::max(0.0, std::abs(z) - kDoubt), z) / std::sqrt(2.0));
}

/// With what is known beforehand, where the two do not contradict each other.
ContactFit with_usual(ContactFit fit) {
  const double usual = kUsual_s * kUsual_s;
  const double spread = 2.0 * kUsual_s * kUsualSpread_s;
  if (std::abs(fit.tau2_s2 - usual) > kContradiction * std::hypot(fit.sigma2_s2, spread)) return fit;
  const double weight = 1.0 / (fit.sigma2_s2 * fit.sigma2_s2);
  const double usual_weight = 1.0 / (spread * spread);
  fit.tau2_s2 = (weight * fit.tau2_s2 + usual_weight * usual) / (weight + usual_weight);
  fit.sigma2_s2 = std::sqrt(1.0 / (weight + usual_weight));
  return fit;
}

/// The root, where it is real.
ContactLaw law_of(const ContactFit& fit) {
  const double square = std::max(fit.tau2_s2, 0.0);
  return {std::sqrt(square), std::sqrt(square + fit.sigma2_s2) - std::sqrt(square)};
}

}  // namespace

double contact_delay(double v_mps, double reference_scaling) {
  return 0.5 * (std::pow(v_mps, -0.2) - reference_scaling);
}

ContactLaw assumed_contact(double rms_hz) {
  if (rms_hz < kSoft_hz) return {0.0, 0.5 / rms_hz};
  return {kUsual_s, kUsualSpread_s, kUsual_s};
}

std::optional<ContactLaw> pool_contacts(const std::vector<ContactEvidence>& drops) {
  if (drops.empty()) return std::nullopt;
  const ContactFit heard[] = {pool(drops, &ContactEvidence::hertz), pool(drops, &ContactEvidence::half_sine)};
  const ContactLaw a = law_of(with_usual(heard[0]));
  const ContactLaw b = law_of(with_usual(heard[1]));
  const double share = share_of_hertz(drops);
  ContactLaw law;
  law.tau_1_s = share * a.tau_1_s + (1.0 - share) * b.tau_1_s;
  law.sigma_s = std::sqrt(share * a.sigma_s * a.sigma_s + (1.0 - share) * b.sigma_s * b.sigma_s +
                          share * (1.0 - share) * std::pow(a.tau_1_s - b.tau_1_s, 2));
  law.hertz_tau_1_s = a.tau_1_s;
  law.is_significant = heard[0].tau2_s2 > kCertain * heard[0].sigma2_s2;
  return law;
}

}  // namespace bouncelab::detection
