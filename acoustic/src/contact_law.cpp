// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_law.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "bouncelab/core/units.hpp"
#include "products.hpp"
#include "pulse_spectrum.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kLeastImpacts = 8;
constexpr std::size_t kMostImpacts = 192;  // more would tell no more than the spread of timbre allows
constexpr std::size_t kMostStacks = 16;
constexpr double kFirstGuess_s = 30e-6;  // steel on glass; the iteration forgets it
constexpr int kMostSteps = 12;
constexpr double kNoiseShare = 8.0;    // times the noise in the response
constexpr double kBelief = 0.45;        // of the pulses' difference: stacks share what neither pulse explains
constexpr double kDamping = 0.8;       // of a step: the strong stacks, which the response follows, lean over
constexpr double kSlowest = 0.125;     // of the fastest impact; below, sounds of others are louder
constexpr double kSignificance = 4.0;  // standard errors at which the law is believed
// f tau up to which a pulse is what its law says: beyond its first zero the spectrum is that of its finer details
constexpr double kLargestProduct = 1.4;

double speed_power(double v_mps) { return std::pow(v_mps, -0.2); }

/// Impacts of about one speed, aligned and added, each as heavy as its amplitude.
struct Stack {
  Spectrum sum;         // of amplitude times sound
  double weight = 0.0;  // of amplitude^2
  double u = 0.0;       // v^(-1/5)
};

/// At most so many, evenly over the list, without the slowest.
std::vector<SpeedAndTime> thin(std::vector<SpeedAndTime> impacts) {
  double fastest_mps = 0.0;
  for (const SpeedAndTime& impact : impacts) fastest_mps = std::max(fastest_mps, impact.v_mps);
  std::erase_if(impacts, [&](const SpeedAndTime& impact) { return impact.v_mps < kSlowest * fastest_mps; });
  if (impacts.size() <= kMostImpacts) return impacts;
  std::vector<SpeedAndTime> some;
  for (std::size_t k = 0; k < kMostImpacts; ++k) some.push_back(impacts[k * impacts.size() / kMostImpacts]);
  return some;
}

std::vector<Stack> stacks_of(const Sound& sound, const ImpactWave& wave, std::vector<SpeedAndTime> impacts) {
  std::sort(impacts.begin(), impacts.end(),
            [](const SpeedAndTime& a, const SpeedAndTime& b) { return a.v_mps > b.v_mps; });
  const std::size_t n_window = wave.wave.n_window();
  const std::size_t n_stacks = std::min(kMostStacks, impacts.size());
  Fourier fourier(n_window);
  std::vector<Stack> stacks(n_stacks);
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    Stack& stack = stacks[k * n_stacks / impacts.size()];
    if (stack.sum.size() == 0)
      stack.sum = {std::vector<float>(n_window / 2 + 1, 0.0F), std::vector<float>(n_window / 2 + 1, 0.0F)};
    const double position = impacts[k].t_s * sound.rate_hz - wave.contact_index;
    const auto first = static_cast<std::int64_t>(std::floor(position));
    WhiteWindow window = read_white(sound, wave.whitener, first, n_window);
    std::fill(window.sound.begin() + static_cast<std::ptrdiff_t>(wave.n_wave), window.sound.end(), 0.0F);
    const double a = impacts[k].amplitude;
    add_scaled(stack.sum,
               product(fourier.forward(window.sound),
                       phasors(n_window / 2 + 1, wave.wave.omega() * (position - static_cast<double>(first)))),
               a);
    stack.weight += a * a;
    stack.u += a * a * speed_power(impacts[k].v_mps);
  }
  for (Stack& stack : stacks) stack.u /= stack.weight;
  return stacks;
}

struct Line {
  double slope = 0.0;
  double sigma = 0.0;
};

/// Weighted regression, far-off points counting less (Huber); its error from its own residuals (White's, robust to
/// unequal scatter).
Line regress(const std::vector<double>& u, const std::vector<double>& y, const std::vector<double>& weight) {
  std::vector<double> w = weight;
  Line line;
  const std::size_t n = u.size();
  std::vector<double> z(n);
  for (int round = 0; round < 8; ++round) {
    double s = 0, su = 0, sy = 0, uu = 0, uy = 0, variance = 0;
    for (std::size_t k = 0; k < n; ++k) s += w[k], su += w[k] * u[k], sy += w[k] * y[k];
    for (std::size_t k = 0; k < n; ++k) {
      uu += w[k] * (u[k] - su / s) * (u[k] - su / s);
      uy += w[k] * (u[k] - su / s) * (y[k] - sy / s);
    }
    line.slope = uy / uu;
    for (std::size_t k = 0; k < n; ++k) {
      const double residual = y[k] - sy / s - line.slope * (u[k] - su / s);
      variance += std::pow(w[k] * (u[k] - su / s) * residual, 2);
      z[k] = std::abs(residual) * std::sqrt(weight[k]);
    }
    line.sigma = std::sqrt(variance * static_cast<double>(n) / static_cast<double>(n - 2)) / uu;
    std::vector<double> sorted = z;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(n / 2), sorted.end());
    const double far = 1.5 * 1.4826 * sorted[n / 2] + 1e-300;
    for (std::size_t k = 0; k < n; ++k) w[k] = weight[k] * std::min(1.0, far / (z[k] + 1e-300));
  }
  return line;
}

class Fitter {
 public:
  Fitter(const std::vector<Stack>& stacks, const PulseSpectrum& pulse, double bin_hz)
      : stacks_(stacks), pulse_(pulse), bin_hz_(bin_hz) {
    double slowest_u = 0.0;
    double weight = 0.0;
    for (const Stack& stack : stacks) slowest_u = std::max(slowest_u, stack.u), weight += stack.weight;
    n_bins_ = std::min(stacks.front().sum.size(),
                       static_cast<std::size_t>(kLargestProduct / (kFirstGuess_s * slowest_u * bin_hz_)) + 1);
    // where the response is mostly noise it is no regressor; the same for every pulse
    for (std::size_t b = 0; b < n_bins_; ++b) {
      double re = 0.0, im = 0.0;
      for (const Stack& stack : stacks) re += stack.sum.re[b], im += stack.sum.im[b];
      trust_.push_back(std::max(0.0, 1.0 - kNoiseShare * weight / (re * re + im * im + 1e-30)));
    }
  }

  std::optional<ContactFit> run() {
    ContactFit fit{kFirstGuess_s, 0.0, {}};
    for (int step = 0; step < kMostSteps; ++step) {
      const Line line = correction(fit);
      if (!std::isfinite(line.slope) || !std::isfinite(line.sigma) || !(line.sigma > 0.0)) return std::nullopt;
      const double next = fit.tau_1_s + kDamping * std::clamp(line.slope, -0.5 * fit.tau_1_s, 0.5 * fit.tau_1_s);
      const bool arrived = std::abs(next - fit.tau_1_s) < 0.05 * line.sigma;
      fit.tau_1_s = next;
      fit.sigma_s = line.sigma;
      if (arrived) break;
    }
    return fit;
  }

 private:
  /// Fits amplitude and duration of each stack to the response of all others; what the durations lack of growing like
  /// v^(-1/5).
  Line correction(ContactFit& fit) {
    const std::size_t n_bins = n_bins_;
    std::vector<std::vector<float>> value(stacks_.size(), std::vector<float>(n_bins));
    std::vector<std::vector<float>> slope = value;
    Spectrum sum{std::vector<float>(n_bins, 0.0F), std::vector<float>(n_bins, 0.0F)};
    std::vector<float> weight(n_bins, 1e-6F);
    for (std::size_t k = 0; k < stacks_.size(); ++k) {
      const Stack& s = stacks_[k];
      pulse_.tabulate(bin_hz_ * fit.tau_1_s * s.u, value[k], slope[k]);
      for (std::size_t b = 0; b < n_bins; ++b) {
        sum.re[b] += value[k][b] * s.sum.re[b];
        sum.im[b] += value[k][b] * s.sum.im[b];
        weight[b] += value[k][b] * value[k][b] * static_cast<float>(s.weight);
      }
    }
    std::vector<double> longer, information, misfits;
    for (std::size_t k = 0; k < stacks_.size(); ++k) {
      const Stack& s = stacks_[k];
      double ww = 0, wl = 0, ll = 0, xw = 0, xl = 0, xx = 0;
      for (std::size_t b = 0; b < n_bins; ++b) {
        const double p = value[k][b];
        const double l = bin_hz_ * static_cast<double>(b) * static_cast<double>(slope[k][b]);
        const double others = static_cast<double>(weight[b]) - p * p * s.weight;
        const double re = (sum.re[b] - p * s.sum.re[b]) / others;
        const double im = (sum.im[b] - p * s.sum.im[b]) / others;
        const double power = re * re + im * im;
        const double trust = trust_[b];
        ww += trust * p * p * power;
        wl += trust * p * l * power;
        ll += trust * l * l * power;
        const double x = trust * (re * s.sum.re[b] + im * s.sum.im[b]);
        xw += p * x;
        xl += l * x;
        xx += trust * (static_cast<double>(s.sum.re[b]) * s.sum.re[b] + static_cast<double>(s.sum.im[b]) * s.sum.im[b]);
      }
      const double determinant = ww * ll - wl * wl;
      const double a = (ll * xw - wl * xl) / determinant;
      const double c = (ww * xl - wl * xw) / determinant;
      longer.push_back(c / a);
      // noise variance of the duration falls as 1/weight until the spread of timbre takes over
      information.push_back(s.weight);
      misfits.push_back((xx - a * xw - c * xl) / s.weight);
    }
    fit.log_misfit.clear();
    for (const double misfit : misfits) fit.log_misfit.push_back(std::log(std::max(misfit, 1e-30)));
    std::vector<double> sorted = information;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double middle = sorted[sorted.size() / 2];
    for (double& w : information) w = w / (w + middle);
    // What all stacks have in common the response takes up. Since ln P falls like the square of the duration, a tau_1
    // that is too short by d leaves stack k with a duration that lacks d (u - <u^2>/u).
    double mean_square = 0.0;
    double weights = 0.0;
    for (const Stack& s : stacks_) mean_square += s.weight * s.u * s.u, weights += s.weight;
    mean_square /= weights;
    std::vector<double> against;
    for (const Stack& s : stacks_) against.push_back(s.u - mean_square / s.u);
    return regress(against, longer, information);
  }

  const std::vector<Stack>& stacks_;
  const PulseSpectrum& pulse_;
  double bin_hz_;
  std::size_t n_bins_ = 0;
  std::vector<double> trust_;
};

/// How probable it is that Hertz's pulse leaves less than the half-sine, over all stacks.
double share_of_hertz(const std::vector<ContactEvidence>& drops) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const ContactEvidence& drop : drops)
    for (std::size_t k = 0; k < drop.hertz.log_misfit.size(); ++k) {
      const double less = drop.half_sine.log_misfit[k] - drop.hertz.log_misfit[k];
      n += 1.0, sum += less, squares += less * less;
    }
  const double error = std::sqrt(std::max(squares - sum * sum / n, 1e-30) / (n - 1.0) * n);
  return 0.5 * std::erfc(-kBelief * sum / error / std::sqrt(2.0));
}

ContactFit pool(const std::vector<ContactEvidence>& drops, ContactFit ContactEvidence::*pulse) {
  ContactFit pooled;
  double weights = 0.0;
  for (const ContactEvidence& drop : drops) {
    const ContactFit& fit = drop.*pulse;
    const double weight = 1.0 / (fit.sigma_s * fit.sigma_s);
    weights += weight;
    pooled.tau_1_s += weight * fit.tau_1_s;
  }
  pooled.tau_1_s /= weights;
  double chi2 = 0.0;
  for (const ContactEvidence& drop : drops)
    chi2 += std::pow(((drop.*pulse).tau_1_s - pooled.tau_1_s) / (drop.*pulse).sigma_s, 2);
  const double scatter = drops.size() > 1 ? std::max(1.0, chi2 / static_cast<double>(drops.size() - 1)) : 1.0;
  pooled.sigma_s = std::sqrt(scatter / weights);
  return pooled;
}

}  // namespace

double contact_delay(double v_mps, double reference_u) { return 0.5 * (speed_power(v_mps) - reference_u); }

std::optional<ContactEvidence> learn_contact(const Sound& sound, const ImpactWave& wave,
                                             const std::vector<SpeedAndTime>& all) {
  const std::vector<SpeedAndTime> impacts = thin(all);
  if (impacts.size() < kLeastImpacts) return std::nullopt;
  const std::vector<Stack> stacks = stacks_of(sound, wave, impacts);
  const double bin_hz = sound.rate_hz / static_cast<double>(wave.wave.n_window());
  const std::optional<ContactFit> hertz = Fitter(stacks, PulseSpectrum::hertz(), bin_hz).run();
  const std::optional<ContactFit> half_sine = Fitter(stacks, PulseSpectrum::half_sine(), bin_hz).run();
  if (!hertz || !half_sine) return std::nullopt;
  ContactEvidence evidence{*hertz, *half_sine, 0.0};
  double weight = 0.0;
  for (const Stack& stack : stacks) {
    evidence.reference_u += stack.weight * stack.u;
    weight += stack.weight;
  }
  evidence.reference_u /= weight;
  return evidence;
}

std::optional<ContactLaw> pool_contacts(const std::vector<ContactEvidence>& drops) {
  if (drops.empty()) return std::nullopt;
  const ContactFit a = pool(drops, &ContactEvidence::hertz);
  const ContactFit b = pool(drops, &ContactEvidence::half_sine);
  const double share = share_of_hertz(drops);
  const double tau_1_s = share * a.tau_1_s + (1.0 - share) * b.tau_1_s;
  const double sigma_s = std::sqrt(share * a.sigma_s * a.sigma_s + (1.0 - share) * b.sigma_s * b.sigma_s +
                                   share * (1.0 - share) * std::pow(a.tau_1_s - b.tau_1_s, 2));
  if (!(tau_1_s > kSignificance * sigma_s)) return std::nullopt;
  return ContactLaw{tau_1_s, sigma_s};
}

}  // namespace bouncelab
