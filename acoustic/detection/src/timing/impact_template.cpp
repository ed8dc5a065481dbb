// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/impact_template.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/statistics.hpp"
#include "timing/correlation_peaks.hpp"
#include "timing/impact_whitener.hpp"
#include "timing/subband_jitter.hpp"
#include "timing/subband_noise.hpp"
#include "timing/template_training.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMaxShown = 12;  // impacts that `waveform` is the mean of
constexpr int kAlignmentRounds = 2;
constexpr std::size_t kResidualOrder = 32;
constexpr std::size_t kMinSubbands = 2;  // from which their disagreement gives the jitter
constexpr float kOnsetOfPeak = 0.1F;     // a plate's first motion is above, noise and a converter's pre-ringing below

/// What the steps of the estimation pass on.
struct Estimation {
  const audio::AudioSource& sound;
  TemplateWindow window;
  audio::RealFft fourier;
  std::vector<std::int64_t> begins;  // of the training impacts' windows, by their candidates
  std::vector<TrainingImpact> training;
  ImpactTemplate learned;
  std::vector<float> mean;  // of the last average, as a function of time
  bool only_lower_half = false;
  std::size_t n_bins = 0;  // that the template may fill
};

double power_at(const audio::Spectrum& spectrum, std::size_t k) {
  return square(static_cast<double>(spectrum.re[k])) + square(static_cast<double>(spectrum.im[k]));
}

void cut(Estimation& e, std::int64_t first, TrainingImpact& impact) {
  cut_window(e.sound, e.learned.whitener, first, e.fourier, e.window.n_window, impact);
}

/// Leaves the lower frequencies, which hold half of the energy.
/// @return the first bin left out
std::size_t keep_lower_half(audio::Spectrum& spectrum) {
  const double half = 0.5 * audio::energy(spectrum);
  double sum = 0.0;
  std::size_t n_kept = 0;
  while (n_kept < spectrum.size() && sum <= half) sum += power_at(spectrum, n_kept++);
  std::fill(spectrum.re.begin() + static_cast<std::ptrdiff_t>(n_kept), spectrum.re.end(), 0.0F);
  std::fill(spectrum.im.begin() + static_cast<std::ptrdiff_t>(n_kept), spectrum.im.end(), 0.0F);
  return n_kept;
}

void set_template(Estimation& e, TemplateAverage average) {
  e.mean = std::move(average.mean);
  e.n_bins = e.only_lower_half ? keep_lower_half(average.spectrum) : average.spectrum.size();
  e.learned.filter = MatchedFilter(std::move(average.spectrum), e.window.n_window);
  if (e.learned.subbands.n() == 0) e.learned.subbands = split_into_subbands(e.learned.filter);
}

void average(Estimation& e) { set_template(e, average_of(e.training, e.window, e.fourier)); }

/// Position and amplitude of each training impact by the present template.
/// @param search  anew within a millisecond, not only about the last position
void align(Estimation& e, bool search) {
  const double reach = kRoughTimeError_s * e.sound.rate_hz;
  for (TrainingImpact& impact : e.training) {
    if (!(e.learned.filter.energy() > 0.0)) {
      impact.correlation = 0.0;
      continue;
    }
    if (search)
      impact.position = find_correlation_peaks(e.learned.filter, impact.spectrum, -reach, reach).front().shift;
    if (std::abs(impact.position) > kRecutDistance_samples) {
      const std::int64_t moved = std::llround(impact.position);
      cut(e, impact.window.first + moved, impact);
      impact.position -= static_cast<double>(moved);
    }
    impact.estimate = estimate_delay(e.learned.filter, e.learned.subbands, impact.spectrum, impact.position);
    impact.position = impact.estimate.shift;
    impact.estimate.amplitude = std::max(impact.estimate.amplitude, 1e-6);
    double total = 0.0;
    for (std::size_t k = 0; k < e.n_bins; ++k) total += power_at(impact.spectrum, k);
    impact.correlation = correlation(impact.estimate, total);
  }
}

/// @param n_searched  rounds in which positions are searched for; in the others they are refined
void align_and_average(Estimation& e, int n_searched, int n_rounds = kAlignmentRounds) {
  for (int round = 0; round < n_rounds; ++round) {
    align(e, round < n_searched);
    average(e);
  }
}

/// How a template is searched for.
struct TemplateSearch {
  bool at_attacks = false;       // windows begin at attacks, not at candidates
  bool lower_half_first = true;  // the first alignment is by the lower half of the spectrum alone
};

/// From the first sample of a window to where it should begin: what a codec lets sound before an attack, and the soft
/// beginning of a soft ball's, may be taken for the impact. The attack is where a fifth of the energy has come.
std::int64_t samples_to_attack(const Estimation& e, std::int64_t first) {
  constexpr double kShareOfEnergy = 0.2;
  const std::vector<float> x = audio::read_white(e.sound, e.learned.whitener, first, e.window.n_window).sound;
  const double enough = kShareOfEnergy * audio::dot(x, x);
  double sum = 0.0;
  std::size_t n = 0;
  while (n + 1 < x.size() && sum < enough) sum += square(static_cast<double>(x[n++]));
  const std::int64_t late = static_cast<std::int64_t>(n) - e.window.samples(kTemplateLead_s);
  return late > e.window.samples(kRoughTimeError_s) ? late : 0;
}

void cut_training(Estimation& e, const TemplateSearch& search) {
  e.training.clear();
  for (const std::int64_t first : e.begins) {
    TrainingImpact impact;
    cut(e, first + (search.at_attacks ? samples_to_attack(e, first) : 0), impact);
    e.training.push_back(std::move(impact));
  }
}

/// The template that starts from one impact. Low frequencies are aligned by first: they have one maximum where high
/// ones have many, and a codec keeps their phases, but gives high ones phases of its own.
void start_from(Estimation& e, std::size_t start, const TemplateSearch& search) {
  e.learned.subbands = {};
  e.only_lower_half = search.lower_half_first;
  set_template(e, first_template(e.training[start], e.window, e.fourier));
  align_and_average(e, kAlignmentRounds);
  if (!e.only_lower_half) return;
  e.only_lower_half = false;
  e.learned.subbands = {};
  average(e);
  align_and_average(e, 0, 1);
}

/// A template and the impacts that it is the mean of.
struct Found {
  ImpactTemplate learned;
  std::vector<TrainingImpact> training;
  std::vector<float> mean;
  bool at_attacks = false;

  std::ptrdiff_t n_alike() const {
    return std::count_if(training.begin(), training.end(),
                         [](const TrainingImpact& impact) { return impact.is_averaged(); });
  }
  bool is_enough() const { return 4 * n_alike() >= 3 * std::ssize(training); }
};

Found state_of(const Estimation& e) { return {e.learned, e.training, e.mean, false}; }

void restore(Estimation& e, Found found) {
  e.learned = std::move(found.learned);
  e.training = std::move(found.training);
  e.mean = std::move(found.mean);
}

/// The template of the strongest impact that three quarters of the others correlate with. The very strongest may hold a
/// knock, or be of another source altogether.
/// @return where there is none, that which most correlate with
Found find_template(Estimation& e, const TemplateSearch& search) {
  constexpr std::size_t kMaxStarts = 5;
  Found best;
  for (std::size_t start = 0; start < std::min(kMaxStarts, e.begins.size()); ++start) {
    cut_training(e, search);
    start_from(e, start, search);
    Found found = state_of(e);
    found.at_attacks = search.at_attacks;
    if (start == 0 || found.n_alike() > best.n_alike()) best = std::move(found);
    if (best.is_enough()) break;
  }
  return best;
}

/// Windows that begin at attacks may lack what the impacts have in common before them, the plate's own sound before a
/// wall's louder answer: moves all of them back by the median of what they were moved, and averages anew.
void include_what_comes_before(Estimation& e) {
  std::vector<double> late;
  for (const std::int64_t first : e.begins) late.push_back(static_cast<double>(samples_to_attack(e, first)));
  const auto most = static_cast<std::int64_t>(e.window.n_template / 3);  // the rest must hold the attack
  const std::int64_t back = std::min(std::llround(upper_median(std::move(late))), static_cast<long long>(most));
  if (back == 0) return;
  for (TrainingImpact& impact : e.training) cut(e, impact.window.first - back, impact);
  e.learned.subbands = {};
  average(e);
  align_and_average(e, 0, 1);
}

/// The same, one way after the other until three quarters of the impacts are alike.
void find_template(Estimation& e) {
  Found best = find_template(e, {});
  for (const TemplateSearch& search : {TemplateSearch{.at_attacks = true}, TemplateSearch{.lower_half_first = false}}) {
    if (best.is_enough()) break;
    Found found = find_template(e, search);
    if (found.n_alike() > best.n_alike()) best = std::move(found);
  }
  const bool at_attacks = best.at_attacks;
  restore(e, std::move(best));
  if (at_attacks) include_what_comes_before(e);
}

/// The template anew by the noise's own whitener, from the positions known: what a share of the impacts' power stood
/// for is known from the residuals from here on. Leaves the whitener where fewer impacts are alike by the noise's: it
/// is that of digital silence, or of a codec's gaps in the spectrum, which the impacts fill each in its own way.
void whiten_by_noise(Estimation& e, const audio::ArModel& noise) {
  if (!(noise.quiet_variance > 0.0)) return;
  Found before = state_of(e);
  e.learned.whitener = noise_whitener(noise);
  for (TrainingImpact& impact : e.training) cut(e, impact.window.first, impact);
  e.learned.subbands = {};
  average(e);
  align_and_average(e, 0, 1);
  if (state_of(e).n_alike() < before.n_alike()) restore(e, std::move(before));
}

/// What the template leaves of a training impact.
std::vector<float> residual_of(Estimation& e, const TrainingImpact& impact) {
  const MatchedFilter& filter = e.learned.filter;
  const std::vector<float> placed =
      e.fourier.inverse(audio::phase_shifted(filter.spectrum(), -filter.omega() * impact.position));
  std::vector<float> x = impact.window.sound;
  for (std::size_t n = 0; n < e.window.n_window; ++n) x[n] -= static_cast<float>(impact.estimate.amplitude) * placed[n];
  return x;
}

/// Extends the whitener by a filter that also whitens what the template does not explain: noise where that is all, the
/// ringing of modes that are excited differently each time where the noise is less than their variation.
void whiten_residuals(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> r(kResidualOrder + 1, 0.0);
  for (const TrainingImpact& impact : e.training) {
    const std::vector<float> x = residual_of(e, impact);
    const double energy = audio::dot(x, x) + 1e-30;
    for (std::size_t lag = 0; lag <= kResidualOrder; ++lag) r[lag] += audio::dot(x, std::span(x).subspan(lag)) / energy;
  }
  const std::vector<double> a = audio::prediction_error_filter(r);
  std::vector<float> both(learned.whitener.size() + kResidualOrder, 0.0F);
  for (std::size_t j = 0; j < learned.whitener.size(); ++j)
    for (std::size_t k = 0; k <= kResidualOrder; ++k) both[j + k] += learned.whitener[j] * static_cast<float>(a[k]);
  learned.whitener = std::move(both);
}

/// The template anew after a new whitener, from the windows as they lie.
void refine_template(Estimation& e) {
  for (TrainingImpact& impact : e.training) cut(e, impact.window.first, impact);
  average(e);
  align_and_average(e, 1);  // the new whitener may have resolved what was ambiguous
}

/// Degrees of freedom of what varies from impact to impact, (tr C)^2 / tr C^2 with the covariance C of the residuals r,
/// each over its amplitude: over such a number of directions their power is spread (Welch-Satterthwaite). The products
/// of different impacts estimate tr C^2 without bias.
double degrees_of_freedom(Estimation& e) {
  constexpr double kFewest = 2.0;  // in phase and in quadrature
  std::vector<std::vector<float>> residuals;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    residuals.push_back(residual_of(e, impact));
    for (float& x : residuals.back()) x /= static_cast<float>(impact.estimate.amplitude);
  }
  double trace = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    trace += audio::dot(residuals[k], residuals[k]);
    for (std::size_t j = 0; j < k; ++j) squares += 2.0 * square(audio::dot(residuals[j], residuals[k]));
  }
  const auto n = static_cast<double>(residuals.size());
  const double trace_of_square = squares / (n * (n - 1.0) + 1e-30);
  trace /= n + 1e-30;
  return std::clamp(trace * trace / (trace_of_square + 1e-30), kFewest, static_cast<double>(e.window.n_window));
}

/// A single sub-band cannot disagree: of what neither template nor noise explains, the delay takes the share of one of
/// the directions that it is spread over. (Half of it, in quadrature, would be too much: a mode that is excited more or
/// less strongly keeps its phase.)
/// @param quiet  sum of squares of a window without impact
void add_unexplained_jitter(Estimation& e, double quiet) {
  std::vector<double> unexplained;  // over what the template explains
  for (const TrainingImpact& impact : e.training) {
    const double explained = 2.0 * impact.estimate.log_likelihood_ratio;
    if (impact.is_averaged()) unexplained.push_back(std::max(0.0, impact.total - explained - quiet) / explained);
  }
  if (unexplained.empty()) return;
  const double dof = degrees_of_freedom(e);
  const double phase2 = upper_median(std::move(unexplained)) / dof;
  const MatchedFilter& filter = e.learned.filter;
  Subbands& subbands = e.learned.subbands;
  for (std::size_t j = 0; j < subbands.n(); ++j)
    subbands.jitter2[j] =
        std::max(subbands.jitter2[j], phase2 * filter.energy(subbands.edge[j], subbands.edge[j + 1]) /
                                          (filter.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30));
}

void estimate_subbands(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  learned.subbands = split_into_subbands(learned.filter);
  std::vector<std::int64_t> begins;
  for (const TrainingImpact& impact : e.training) begins.push_back(impact.window.first);
  const double quiet = estimate_noise(e.sound, learned.whitener, begins, learned.filter, learned.subbands);
  for (int round = 0; round < 2; ++round) {
    align(e, false);
    std::vector<DelayEstimate> estimates;
    for (const TrainingImpact& impact : e.training)
      if (impact.is_averaged()) estimates.push_back(impact.estimate);
    estimate_jitter(estimates, learned.filter, learned.subbands);
    if (learned.subbands.n() < kMinSubbands) add_unexplained_jitter(e, quiet);
    average(e);
  }
}

/// Start of contact in the window: the first sample above a tenth of the peak.
double onset_index(const std::vector<float>& mean) {
  float peak = 0.0F;
  for (const float x : mean) peak = std::max(peak, std::abs(x));
  const auto first = std::find_if(mean.begin(), mean.end(), [&](float x) { return std::abs(x) > kOnsetOfPeak * peak; });
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

void describe_training(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> correlations;
  for (const TrainingImpact& impact : e.training) correlations.push_back(impact.correlation);
  learned.correlation = upper_median(std::move(correlations));
  learned.contact_index = onset_index(e.mean);
  learned.n_effective = effective_samples(e.mean);
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    ++learned.n_impacts;
    const double begin = static_cast<double>(impact.window.first) + impact.position + learned.contact_index;
    learned.training_t_s.push_back(begin / e.sound.rate_hz);
    learned.training_weight += impact.estimate.amplitude * impact.estimate.amplitude;
  }
}

/// Mean of the training impacts as recorded, and its spread.
void describe_waveform(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  const std::size_t n_window = e.window.n_window;
  std::vector<double> sum(n_window, 0.0);
  std::vector<double> squares(n_window, 0.0);
  std::vector<float> x(n_window);
  double n = 0.0;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged() || n >= kMaxShown) continue;
    audio::read_padded(e.sound, impact.window.first, x);
    const audio::Spectrum moved = audio::phase_shifted(e.fourier.forward(x), learned.filter.omega() * impact.position);
    const std::vector<float> y = e.fourier.inverse(moved);
    for (std::size_t k = 0; k < n_window; ++k) {
      const double value = y[k] / impact.estimate.amplitude;
      sum[k] += value;
      squares[k] += value * value;
    }
    n += 1.0;
  }
  learned.waveform.resize(learned.n_template);
  learned.spread.resize(learned.n_template);
  for (std::size_t k = 0; k < learned.n_template; ++k) {
    learned.waveform[k] = sum[k] / n;
    learned.spread[k] = std::sqrt(std::max(0.0, squares[k] / n - learned.waveform[k] * learned.waveform[k]));
    learned.peak = std::max(learned.peak, std::abs(learned.waveform[k]));
  }
}

Estimation begin_estimation(const audio::AudioSource& sound, const audio::ArModel& noise,
                            const std::vector<Candidate>& impacts, const std::vector<bool>& clipped) {
  const TemplateWindow window = template_window(sound, impacts);
  Estimation e{sound, window, audio::RealFft(window.n_window), {}, {}, {}, {}};
  e.learned.n_template = window.n_template;
  for (const std::size_t k : choose_training_impacts(impacts, clipped))
    e.begins.push_back(window.samples(impacts[k].t_s - kTemplateLead_s));
  e.learned.whitener = impact_whitener(sound, noise, e.begins, window.n_window);
  return e;
}

}  // namespace

std::optional<ImpactTemplate> estimate_template(const audio::AudioSource& sound, const audio::ArModel& noise,
                                                const std::vector<Candidate>& impacts, const std::vector<bool>& clipped,
                                                float clip_level) {
  if (impacts.size() < 3) return std::nullopt;
  Estimation e = begin_estimation(sound, noise, impacts, clipped);
  find_template(e);
  whiten_by_noise(e, noise);
  whiten_residuals(e);
  refine_template(e);
  estimate_subbands(e);
  describe_training(e);
  if (e.learned.n_impacts < 3) return std::nullopt;
  describe_waveform(e);
  // a template of clipped impacts is clipped itself: then samples beyond the limit fit it and must not be left out
  if (has_enough_unclipped(clipped)) e.learned.clip_level = clip_level;
  return std::move(e.learned);
}

bool has_enough_unclipped(const std::vector<bool>& clipped) {
  return std::count(clipped.begin(), clipped.end(), false) >= kMinUnclipped;
}

double correlation(const DelayEstimate& estimate, double total) {
  return std::sqrt(std::min(1.0, 2.0 * estimate.log_likelihood_ratio / (total + 1e-30)));
}

}  // namespace bouncelab::detection
