// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/impact_template.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "template/subband_delay.hpp"

namespace bouncelab::detection {
namespace {

constexpr int kJitterRounds = 8;
constexpr double kLittle = 2e-3;  // relative change of each jitter; 32 impacts determine one to 12 %

/// Jitter at which half of the squared deviations of one sub-band, each over its expected value, are below the median
/// of chi-squared: impacts in the ringing of others, fewer than half, do not count for what the rest show.
/// @param squares  over the share of its variance that a deviation keeps
double jitter_of(const std::vector<double>& squares, const std::vector<double>& noise) {
  constexpr double kMedianOfChi2 = 0.455;  // with one degree of freedom
  std::vector<double> jitter2;
  for (std::size_t k = 0; k < squares.size(); ++k) jitter2.push_back(squares[k] / kMedianOfChi2 - noise[k]);
  return std::max(0.0, upper_median(std::move(jitter2)));
}

/// Variance of a sub-band's delay [samples^2] where that of its phase is 1.
double delay_of_phase2(const MatchedFilter& filter, const Subbands& subbands, std::size_t j) {
  return filter.energy(subbands, j) / (filter.information(subbands, j) + 1e-30);
}

/// Phases vary about alike at all frequencies: the variance of each sub-band's phase is averaged with the median one.
void average_with_median(const MatchedFilter& filter, Subbands& subbands) {
  const std::size_t n = subbands.n();
  std::vector<double> phase2(n);
  for (std::size_t j = 0; j < n; ++j) phase2[j] = subbands.jitter2[j] / (delay_of_phase2(filter, subbands, j) + 1e-30);
  const double typical = upper_median(std::move(phase2));
  for (std::size_t j = 0; j < n; ++j)
    subbands.jitter2[j] = 0.5 * (subbands.jitter2[j] + typical * delay_of_phase2(filter, subbands, j));
}

bool have_settled(const std::vector<double>& before, const std::vector<double>& after) {
  for (std::size_t j = 0; j < after.size(); ++j)
    if (std::abs(after[j] - before[j]) > kLittle * after[j]) return false;
  return true;
}

constexpr double kMinNoise = 1e-6;  // of white noise of variance 1

struct QuietWindow {
  double weighted_power = 0.0;  // with the weights of the delay, over all sub-bands
  double energy = 0.0;          // sum of squares
  std::vector<double> power;    // by sub-band
};

std::vector<std::vector<float>> residuals_of(TemplateEstimation& e) {
  std::vector<std::vector<float>> residuals;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    residuals.push_back(residual_of(e, impact));
    for (float& x : residuals.back()) x /= static_cast<float>(impact.estimate.amplitude);
  }
  return residuals;
}

/// Sets the jitter variance of each sub-band by variance components: the squared deviations from the mean, corrected
/// for what the mean follows, minus those that noise explains; averaged with the median phase variance of all
/// sub-bands, since the deviations of one that dominates the mean are small whatever its jitter. Leaves all as it is
/// with fewer than three estimates or two sub-bands.
/// @param estimates  of many impacts of one recording
/// @param filter     that of the estimates
void estimate_jitter(const std::vector<DelayEstimate>& estimates, const MatchedFilter& filter, Subbands& subbands) {
  const std::size_t n = subbands.n();
  if (estimates.size() < 3 || n < 2) return;
  for (int round = 0; round < kJitterRounds; ++round) {
    std::vector<std::vector<double>> squares(n), noise(n);  // by sub-band and impact
    for (const DelayEstimate& r : estimates) {
      const SubbandMean mean = subband_mean(subbands, r);
      for (std::size_t j = 0; j < n; ++j) {
        // over Var(d_j - mean) / Var(d_j): the mean follows each sub-band
        const double share = std::max(kTemplate.least_residual_share, 1.0 - mean.weight[j]);
        squares[j].push_back(square(r.deviation[j] - mean.deviation) / share);
        noise[j].push_back(r.noise_variance[j]);
      }
    }
    const std::vector<double> before = subbands.jitter2;
    for (std::size_t j = 0; j < n; ++j) subbands.jitter2[j] = jitter_of(squares[j], noise[j]);
    average_with_median(filter, subbands);
    if (have_settled(before, subbands.jitter2)) break;
  }
}

/// Sets each sub-band's noise: the variance in each real and imaginary part, averaged over its bins with the weights
/// omega^2 |W|^2 that the delay gives them. (A plain mean is wrong where the whitened noise is not flat within a
/// sub-band; and it is not flat where the whitener has modelled the modes too: it is low just where the template is
/// strong.) Estimated from the quieter half of the windows that end where those of the training impacts begin; in the
/// others an earlier impact still rings.
/// @return  mean square of such a window
double estimate_noise(TemplateEstimation& e) {
  const MatchedFilter& filter = e.learned.filter;
  Subbands& subbands = e.learned.subbands;
  std::vector<QuietWindow> windows;
  std::vector<float> white(filter.n_window());
  for (const TrainingImpact& impact : e.training) {
    e.white->read(e.learned.whitener, impact.first - std::ssize(white), white);
    const audio::Spectrum spectrum = e.fourier.forward(white);
    QuietWindow& quiet = windows.emplace_back();
    quiet.energy = audio::dot(white, white);
    for (std::size_t j = 0; j < subbands.n(); ++j) {
      const double sum = filter.information_times_power_of(spectrum, subbands, j);
      quiet.power.push_back(0.5 * sum / (filter.information(subbands, j) + 1e-30));
      quiet.weighted_power += sum;
    }
  }
  const std::size_t n_quiet = (windows.size() + 1) / 2;
  // sorted, not parted: the order of the sums below would be that of one standard library
  std::sort(windows.begin(), windows.end(),
            [](const QuietWindow& a, const QuietWindow& b) { return a.weighted_power < b.weighted_power; });
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n_quiet; ++k) sum += windows[k].power[j];
    subbands.noise[j] = std::max(sum / static_cast<double>(n_quiet), kMinNoise);
  }
  double energy = 0.0;
  for (std::size_t k = 0; k < n_quiet; ++k) energy += windows[k].energy / static_cast<double>(n_quiet);
  return energy / static_cast<double>(filter.n_window());
}

/// Degrees of freedom of what varies from impact to impact, (tr C)^2 / tr C^2 with the covariance C of the residuals:
/// over such a number of directions their power is spread (Welch-Satterthwaite). The products of different residuals
/// estimate tr C^2 without bias. Between 2 and the length of a residual.
/// @param residuals  of equal length, each over the amplitude of its impact
double degrees_of_freedom(const std::vector<std::vector<float>>& residuals) {
  constexpr double kFewest = 2.0;  // in phase and in quadrature
  if (residuals.size() < 2) return kFewest;
  double trace = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    trace += audio::dot(residuals[k], residuals[k]);
    for (std::size_t j = 0; j < k; ++j) squares += 2.0 * square(audio::dot(residuals[j], residuals[k]));
  }
  const auto n = static_cast<double>(residuals.size());
  trace /= n;
  squares /= n * (n - 1.0);
  const auto most = static_cast<double>(residuals.front().size());
  return squares > 0.0 ? std::clamp(trace * trace / squares, kFewest, most) : most;
}

/// A single sub-band cannot disagree: of what neither template nor noise explains, the delay takes the share of one of
/// the directions that it is spread over. (Half of it, in quadrature, would be too much: a mode that is excited more or
/// less strongly keeps its phase.)
/// @param quiet  mean square of a window without impact
void add_unexplained_jitter(TemplateEstimation& e, double quiet) {
  const std::vector<std::vector<float>> residuals = residuals_of(e);
  std::vector<double> unexplained;  // over what the template explains
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    const std::vector<float>& x = residuals[unexplained.size()];
    const double noise = quiet * static_cast<double>(x.size()) / square(impact.estimate.amplitude);
    unexplained.push_back(std::max(0.0, audio::dot(x, x) - noise) / e.learned.filter.energy());
  }
  if (unexplained.empty()) return;
  const double dof = degrees_of_freedom(residuals);
  const double phase2 = upper_median(std::move(unexplained)) / dof;
  const MatchedFilter& filter = e.learned.filter;
  Subbands& subbands = e.learned.subbands;
  for (std::size_t j = 0; j < subbands.n(); ++j)
    subbands.jitter2[j] = std::max(subbands.jitter2[j], phase2 * delay_of_phase2(filter, subbands, j));
}

constexpr std::size_t kMaxShown = 12;  // impacts that the wave is the mean of

/// Extends the whitener by a filter that also whitens what the template does not explain: noise where that is all, the
/// ringing of modes that are excited differently each time where the noise is less than their variation. The template
/// anew, from the windows as they lie.
void whiten_residuals(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> r(kTemplate.residual_order + 1, 0.0);
  for (const TrainingImpact& impact : e.training) {
    const std::vector<float> x = residual_of(e, impact);
    const double energy = audio::dot(x, x) + 1e-30;
    for (std::size_t lag = 0; lag < std::min(r.size(), x.size()); ++lag)
      r[lag] += audio::dot(x, std::span(x).subspan(lag)) / energy;
  }
  const std::vector<double> a = prediction_error_filter(r);
  std::vector<float> both(learned.whitener.size() + kTemplate.residual_order, 0.0F);
  for (std::size_t j = 0; j < learned.whitener.size(); ++j)
    for (std::size_t k = 0; k <= kTemplate.residual_order; ++k)
      both[j + k] += learned.whitener[j] * static_cast<float>(a[k]);
  learned.whitener = std::move(both);
  for (TrainingImpact& impact : e.training) cut_training_window(e, impact.first, impact);
  average(e);
  align(e, true);  // the new whitener may have resolved what was ambiguous
  average(e);
}

void estimate_subbands(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  learned.subbands = split_into_subbands(learned.filter);
  const double quiet = estimate_noise(e);
  align(e, false);
  std::vector<DelayEstimate> estimates;
  for (const TrainingImpact& impact : e.training)
    if (impact.is_averaged()) estimates.push_back(impact.estimate);
  estimate_jitter(estimates, learned.filter, learned.subbands);
  if (learned.subbands.n() < kTemplate.fewest_subbands) add_unexplained_jitter(e, quiet);
}

/// Start of contact in the window: the first sample above a tenth of the peak.
double onset_index(const std::vector<float>& mean) {
  float peak = 0.0F;
  for (const float x : mean) peak = std::max(peak, std::abs(x));
  const auto first =
      std::find_if(mean.begin(), mean.end(), [&](float x) { return std::abs(x) > kTemplate.onset_of_peak * peak; });
  return static_cast<double>(first - mean.begin());
}

double effective_samples(const std::vector<float>& wave) {
  double squares = 1e-30, fourth_powers = 1e-30;
  for (const float x : wave) {
    const double x2 = square(static_cast<double>(x));
    squares += x2;
    fourth_powers += x2 * x2;
  }
  return std::min(3.0 * squares * squares / fourth_powers, static_cast<double>(wave.size()));
}

void describe_training(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> correlations;
  for (const TrainingImpact& impact : e.training) correlations.push_back(impact.correlation);
  learned.correlation = upper_median(std::move(correlations));
  learned.contact_index = onset_index(e.mean);
  learned.n_effective = effective_samples(e.mean);
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    const double begin = static_cast<double>(impact.first) + impact.estimate.shift + learned.contact_index;
    learned.training_t_s.push_back(begin / e.white->source().rate_hz);
    learned.training_weight += impact.estimate.amplitude * impact.estimate.amplitude;
  }
}

/// Mean of the training impacts as recorded, and its spread.
void describe_waveform(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> sum(learned.n_template, 0.0);
  std::vector<double> squares(learned.n_template, 0.0);
  std::vector<float> x(e.fourier.size());
  std::size_t n_shown = 0;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged() || n_shown == kMaxShown) continue;
    audio::read_padded(e.white->source(), impact.first, x);
    const std::vector<float> y =
        e.fourier.inverse(audio::phase_shifted(e.fourier.forward(x), learned.filter.omega() * impact.estimate.shift));
    const double factor = 1.0 / impact.estimate.amplitude;
    for (std::size_t k = 0; k < learned.n_template; ++k) {
      const double value = factor * static_cast<double>(y[k]);
      sum[k] += value;
      squares[k] += value * value;
    }
    ++n_shown;
  }
  const double rate_hz = e.white->source().rate_hz;
  LearnedWave& wave = learned.wave;
  wave.t0_s = -learned.contact_index / rate_hz;
  wave.dt_s = 1.0 / rate_hz;
  wave.n_impacts = std::ssize(learned.training_t_s);
  const auto n = static_cast<double>(n_shown);
  for (std::size_t k = 0; k < learned.n_template; ++k) {
    wave.mean.push_back(sum[k] / n);
    wave.spread.push_back(std::sqrt(std::max(0.0, squares[k] / n - square(wave.mean[k]))));
    learned.peak = std::max(learned.peak, std::abs(wave.mean[k]));
  }
}

}  // namespace

std::optional<ImpactTemplate> estimate_template(WhiteSound& white, const ArModel& noise,
                                                const std::vector<Candidate>& impacts,
                                                const std::vector<bool>& clipped) {
  if (impacts.size() < 3) return std::nullopt;
  TemplateEstimation e = begin_estimation(white, impacts, clipped);
  e.learned.whitener = impact_whitener(white.source(), noise, e.begins, e.fourier.size(), kTemplate.unrepeated);
  find_template(e);
  whiten_by_noise(e, noise);
  whiten_residuals(e);
  estimate_subbands(e);
  describe_training(e);
  if (e.learned.training_t_s.size() < 3) return std::nullopt;
  describe_waveform(e);
  return std::move(e.learned);
}

double correlation(const DelayEstimate& estimate, double total) {
  return std::sqrt(std::min(1.0, 2.0 * estimate.log_likelihood_ratio / (total + 1e-30)));
}

namespace {

/// Spectrum of the template's whitener at the bins of its own.
audio::Spectrum whitener_response(const ImpactTemplate& learned) {
  const std::size_t n_window = learned.filter.n_window();
  // long enough for the whitener also at low rates
  const std::size_t n = std::max(n_window, std::bit_ceil(learned.whitener.size()));
  audio::Spectrum response = audio::RealFft(n).forward(learned.whitener);
  for (std::size_t k = 0; k <= n_window / 2; ++k) {
    response.re[k] = response.re[k * (n / n_window)];
    response.im[k] = response.im[k * (n / n_window)];
  }
  return response;
}

}  // namespace

audio::Spectrum recorded_phases(const ImpactTemplate& learned) {
  const audio::Spectrum response = whitener_response(learned);
  audio::Spectrum modes = audio::product_conj(response, learned.filter.spectrum(), learned.filter.spectrum().size(),
                                              learned.filter.omega() * learned.contact_index);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const double gain = std::sqrt(audio::bin_power(response, k) * learned.filter.energy()) + 1e-30;
    modes.re[k] = static_cast<float>(modes.re[k] / gain);
    modes.im[k] = static_cast<float>(modes.im[k] / gain);
  }
  return modes;
}

double recorded_rms_frequency(const ImpactTemplate& learned) {
  const std::size_t n_window = learned.filter.n_window();
  const audio::Spectrum response = whitener_response(learned);
  double power = 0.0, squares = 0.0;
  for (std::size_t k = 1; k < learned.filter.spectrum().size(); ++k) {
    const double gain2 = audio::bin_power(response, k);
    const double recorded = learned.filter.energy(k, k + 1) / (gain2 + 1e-30);
    power += recorded;
    squares += recorded * square(static_cast<double>(k));
  }
  return std::max(1e-6, std::sqrt(squares / (power + 1e-300)) / static_cast<double>(n_window));
}

}  // namespace bouncelab::detection
