// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/impact_template.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/units.hpp"
#include "timing/coherence_weight.hpp"
#include "timing/correlation_peaks.hpp"
#include "timing/subband_jitter.hpp"
#include "timing/subband_noise.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kWave_s = 15e-3;      // holds more than nine tenths of what a plate's sound says of its time
constexpr double kLongWave_s = 40e-3;  // where impacts follow so closely that what rings after 15 ms hides them
constexpr double kClose_s = 20e-3;
constexpr std::size_t kManyClose = 20;
constexpr double kBefore_s = 0.5e-3;  // quiet part in front of the rough time
constexpr double kSearch_s = 1e-3;    // error of the rough times
constexpr double kFade_s = 2e-3;      // at the wave's end
constexpr std::size_t kMostLearned = 32;
constexpr std::size_t kMostHeard = 12;  // of those whose sound is shown
constexpr int kRounds = 2;
constexpr std::size_t kResidualOrder = 32;
constexpr std::size_t kMinSubbands = 3;
constexpr std::size_t kFewestHalved = 4;  // below, halves say nothing
constexpr double kLeastCorrelation = 0.5;
constexpr double kFarOff = 8.0;  // samples; a window further off is cut again

std::int64_t samples(double duration_s, const audio::AudioSource& sound) {
  return std::llround(duration_s * sound.rate_hz);
}

/// One impact to learn from.
struct TrainingImpact {
  audio::WhiteWindow window;
  audio::Spectrum spectrum;
  double total = 0.0;     // sum of squares
  double position = 0.0;  // of the wave within the window
  DelayEstimate reading;
  double correlation = 1.0;
};

/// How much of the wave is to be learned.
double wave_length_s(const std::vector<RoughImpact>& impacts) {
  std::size_t n_close = 0;
  std::size_t n_far = 0;
  for (std::size_t k = 0; k + 1 < impacts.size(); ++k) {
    n_close += impacts[k + 1].t_s - impacts[k].t_s < kClose_s ? 1 : 0;
    n_far += impacts[k + 1].t_s - impacts[k].t_s > 2.0 * kLongWave_s ? 1 : 0;
  }
  return n_close >= kManyClose && n_far >= kMostHeard ? kLongWave_s : kWave_s;
}

/// Strong impacts that ring alone; where none does, the strong ones.
std::vector<std::size_t> choose_training_impacts(const std::vector<RoughImpact>& impacts, double wave_s) {
  std::vector<std::size_t> alone;
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    all.push_back(k);
    const bool next_far = k + 1 == impacts.size() || impacts[k + 1].t_s - impacts[k].t_s > wave_s + 2.0 * kSearch_s;
    const bool last_far = k == 0 || impacts[k].t_s - impacts[k - 1].t_s > wave_s;
    if (next_far && last_far) alone.push_back(k);
  }
  std::vector<std::size_t> whole = alone;
  std::erase_if(whole, [&](std::size_t k) { return impacts[k].clipped; });
  if (std::ssize(whole) >= kFewestWhole) alone = whole;
  std::vector<std::size_t>& chosen = alone.size() >= 5 ? alone : all;
  const auto stronger = [&](std::size_t a, std::size_t b) { return impacts[a].amplitude > impacts[b].amplitude; };
  if (chosen.size() > kMostLearned) {
    std::nth_element(chosen.begin(), chosen.begin() + kMostLearned, chosen.end(), stronger);
    chosen.resize(kMostLearned);
  }
  std::sort(chosen.begin(), chosen.end(), stronger);
  return chosen;
}

class TemplateEstimator {
 public:
  TemplateEstimator(const audio::AudioSource& sound, const std::vector<RoughImpact>& impacts, ImpactTemplate& learned)
      : sound_(sound), impacts_(impacts), learned_(learned) {
    const double wave_s = wave_length_s(impacts);
    chosen_ = choose_training_impacts(impacts, wave_s);
    n_window_ = std::bit_ceil(static_cast<std::size_t>(samples(kBefore_s + wave_s + 2.0 * kSearch_s, sound)));
    learned.n_template = std::min(n_window_, static_cast<std::size_t>(samples(kBefore_s + wave_s, sound)));
    fourier_.emplace(n_window_);
  }

  void read_training_windows() {
    std::vector<TrainingImpact> before = std::move(training_);
    training_.clear();
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      TrainingImpact row;
      const std::int64_t first =
          before.empty() ? samples(impacts_[chosen_[k]].t_s - kBefore_s, sound_) : before[k].window.first;
      if (!before.empty()) row = std::move(before[k]);
      cut(row, first);
      training_.push_back(std::move(row));
    }
  }

  /// Finds the wave from one row: the strongest whose sound at least half of the others share. The very strongest may
  /// have a knock in it, or be another thing altogether.
  void find_wave() {
    constexpr std::size_t kMostStarts = 5;
    std::size_t best_start = 0;
    std::ptrdiff_t most_alike = -1;
    for (std::size_t start = 0; start < std::min(kMostStarts, training_.size()); ++start) {
      begin_from(training_[start]);
      align_and_average(kRounds);
      const std::ptrdiff_t n_alike = std::count_if(training_.begin(), training_.end(), [](const TrainingImpact& row) {
        return row.correlation >= kLeastCorrelation;
      });
      if (2 * n_alike >= std::ssize(training_)) return;
      if (n_alike > most_alike) most_alike = n_alike, best_start = start;
    }
    begin_from(training_[best_start]);
    align_and_average(kRounds);
  }

  /// Again from the rows as they lie, after a new whitener.
  void refine_wave() {
    average();
    align_and_average(1);  // the new whitener may have cleared up what was ambiguous
  }

  /// A filter that also makes white what the wave does not explain: noise where that is all, the ringing of modes that
  /// are struck differently each time where the recording is cleaner than the wave is constant.
  void whiten_residuals() {
    std::vector<double> r(kResidualOrder + 1, 0.0);
    for (const TrainingImpact& row : training_) {
      const std::vector<float> placed =
          fourier_->inverse(audio::phase_shifted(learned_.wave.wave(), -learned_.wave.omega() * row.position));
      std::vector<float> x = row.window.sound;
      for (std::size_t n = 0; n < n_window_; ++n) x[n] -= static_cast<float>(row.reading.amplitude) * placed[n];
      const double energy = audio::dot(x, x) + 1e-30;
      for (std::size_t lag = 0; lag <= kResidualOrder; ++lag)
        r[lag] += audio::dot(x, std::span(x).subspan(lag)) / energy;
    }
    const std::vector<double> a = audio::prediction_error_filter(r);
    std::vector<float> both(learned_.whitener.size() + kResidualOrder, 0.0F);
    for (std::size_t j = 0; j < learned_.whitener.size(); ++j)
      for (std::size_t k = 0; k <= kResidualOrder; ++k) both[j + k] += learned_.whitener[j] * static_cast<float>(a[k]);
    learned_.whitener = std::move(both);
  }

  void estimate_subbands() {
    learned_.subbands = split_into_subbands(learned_.wave);
    std::vector<std::int64_t> begins;
    for (const TrainingImpact& row : training_) begins.push_back(row.window.first);
    const double quiet = estimate_noise(sound_, learned_.whitener, begins, learned_.wave, learned_.subbands);
    for (int round = 0; round < 2; ++round) {
      align(false);
      std::vector<DelayEstimate> readings;
      for (const TrainingImpact& row : training_)
        if (row.correlation >= kLeastCorrelation) readings.push_back(row.reading);
      estimate_jitter(readings, learned_.wave, learned_.subbands);
      if (learned_.subbands.n() < kMinSubbands) add_unexplained_jitter(quiet);
      average();
    }
  }

  void describe() {
    std::vector<double> correlations;
    for (const TrainingImpact& row : training_) {
      correlations.push_back(row.correlation);
      if (row.correlation >= kLeastCorrelation) ++learned_.n_impacts;
    }
    const auto middle = correlations.begin() + static_cast<std::ptrdiff_t>(correlations.size() / 2);
    std::nth_element(correlations.begin(), middle, correlations.end());
    learned_.correlation = *middle;
    learned_.contact_index = begin_of_wave();
    for (const TrainingImpact& row : training_) {
      if (row.correlation < kLeastCorrelation) continue;
      const double begin = static_cast<double>(row.window.first) + row.position + learned_.contact_index;
      learned_.training_t_s.push_back(begin / sound_.rate_hz);
      learned_.training_weight += row.reading.amplitude * row.reading.amplitude;
    }
  }

  /// The mean of the rows as recorded, and how much they differ from it.
  void describe_as_heard() {
    std::vector<double> sum(n_window_, 0.0);
    std::vector<double> squares(n_window_, 0.0);
    std::vector<float> x(n_window_);
    double n = 0.0;
    for (const TrainingImpact& row : training_) {
      if (row.correlation < kLeastCorrelation || n >= kMostHeard) continue;
      audio::read_padded(sound_, row.window.first, x);
      const audio::Spectrum moved = audio::phase_shifted(fourier_->forward(x), learned_.wave.omega() * row.position);
      const std::vector<float> y = fourier_->inverse(moved);
      for (std::size_t k = 0; k < n_window_; ++k) {
        const double value = y[k] / row.reading.amplitude;
        sum[k] += value;
        squares[k] += value * value;
      }
      n += 1.0;
    }
    learned_.waveform.resize(learned_.n_template);
    learned_.spread.resize(learned_.n_template);
    for (std::size_t k = 0; k < learned_.n_template; ++k) {
      learned_.waveform[k] = sum[k] / n;
      learned_.spread[k] = std::sqrt(std::max(0.0, squares[k] / n - learned_.waveform[k] * learned_.waveform[k]));
      learned_.peak = std::max(learned_.peak, std::abs(learned_.waveform[k]));
    }
  }

 private:
  /// One or two subbands cannot disagree: what of the impacts neither the wave nor noise explains is taken for phases
  /// that differ, half of it, in each subband.
  /// @param quiet  sum of squares of a window without impact
  void add_unexplained_jitter(double quiet) {
    std::vector<double> unexplained;  // over what the wave explains
    for (const TrainingImpact& row : training_)
      if (row.correlation >= kLeastCorrelation)
        unexplained.push_back(std::max(0.0, row.total - 2.0 * row.reading.log_likelihood_ratio - quiet) /
                              (2.0 * row.reading.log_likelihood_ratio));
    if (unexplained.empty()) return;
    const auto middle = unexplained.begin() + static_cast<std::ptrdiff_t>(unexplained.size() / 2);
    std::nth_element(unexplained.begin(), middle, unexplained.end());
    const double phase2 = 0.5 * *middle;
    Subbands& subbands = learned_.subbands;
    for (std::size_t j = 0; j < subbands.n(); ++j)
      subbands.jitter2[j] = std::max(subbands.jitter2[j],
                                     phase2 * learned_.wave.energy(subbands.edge[j], subbands.edge[j + 1]) /
                                         (learned_.wave.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30));
  }

  void cut(TrainingImpact& row, std::int64_t first) {
    row.window = audio::read_white(sound_, learned_.whitener, first, n_window_);
    row.spectrum = fourier_->forward(row.window.sound);
    row.total = audio::dot(row.window.sound, row.window.sound);
  }

  /// @param n_searched  rounds in which the rows' places are looked for, then their old ones are refined
  void align_and_average(int n_searched) {
    for (int round = 0; round < kRounds; ++round) {
      align(round < n_searched);
      average();
    }
  }

  void begin_from(const TrainingImpact& row) {
    const double omega = 2.0 * kPi / static_cast<double>(n_window_);
    learned_.subbands = {};
    hold(faded(audio::phase_shifted(row.spectrum, omega * row.position), 1.0));
  }

  /// Average of the rows that sound alike, each as heavy as its amplitude.
  void average() {
    const std::vector<float> none(n_window_ / 2 + 1, 0.0F);
    audio::Spectrum sums[2] = {{none, none}, {none, none}};  // of every other row
    double weights[2] = {0.0, 0.0};
    std::size_t n_rows = 0;
    const double omega = 2.0 * kPi / static_cast<double>(n_window_);
    for (const TrainingImpact& row : training_) {
      if (row.correlation < kLeastCorrelation) continue;
      const double a = row.reading.amplitude;
      const std::size_t half = n_rows++ % 2;
      audio::add_scaled(sums[half], audio::phase_shifted(row.spectrum, omega * row.position), a);
      weights[half] += a * a;
    }
    audio::Spectrum sum = sums[0];
    audio::add_scaled(sum, sums[1], 1.0);
    audio::Spectrum wave = faded(sum, weights[0] + weights[1]);
    if (n_rows >= kFewestHalved) {
      const std::vector<float> share = coherence_weight(sums[0], weights[0], sums[1], weights[1]);
      for (std::size_t k = 0; k < wave.size(); ++k) wave.re[k] *= share[k], wave.im[k] *= share[k];
    }
    hold(std::move(wave));
  }

  /// A sum of rows over its weight, nothing in front of the wave and behind it.
  audio::Spectrum faded(const audio::Spectrum& sum, double weight) {
    std::vector<float> mean = fourier_->inverse(sum);
    const double scale = weight > 0.0 ? 1.0 / weight : 0.0;
    const auto fade = static_cast<std::size_t>(samples(kFade_s, sound_));
    const auto rise = static_cast<std::size_t>(samples(0.25 * kBefore_s, sound_)) + 1;
    for (std::size_t n = 0; n < n_window_; ++n) {
      double w = n < learned_.n_template ? scale : 0.0;
      if (n < rise) w *= std::pow(std::sin(0.5 * kPi * static_cast<double>(n) / static_cast<double>(rise)), 2);
      if (n < learned_.n_template && n + fade > learned_.n_template)
        w *=
            std::pow(std::sin(0.5 * kPi * static_cast<double>(learned_.n_template - n) / static_cast<double>(fade)), 2);
      mean[n] *= static_cast<float>(w);
    }
    mean_ = mean;
    return fourier_->forward(mean);
  }

  void hold(audio::Spectrum wave) {
    learned_.wave = MatchedFilter(std::move(wave), n_window_);
    if (learned_.subbands.n() == 0) learned_.subbands = split_into_subbands(learned_.wave);
  }

  void align(bool search) {
    for (TrainingImpact& row : training_) {
      const double reach = kSearch_s * sound_.rate_hz;
      if (search) row.position = find_correlation_peaks(learned_.wave, row.spectrum, -reach, reach).front().shift;
      if (std::abs(row.position) > kFarOff) {
        const std::int64_t moved = std::llround(row.position);
        cut(row, row.window.first + moved);
        row.position -= static_cast<double>(moved);
      }
      row.reading = estimate_delay(learned_.wave, learned_.subbands, row.spectrum, row.position);
      row.position = row.reading.shift;
      row.reading.amplitude = std::max(row.reading.amplitude, 1e-6);
      row.correlation = correlation(row.reading, row.total);
    }
  }

  /// Where the wave begins: the first sample above a tenth of the peak. Noise and the forerunners of a linear-phase
  /// converter stay below; a plate's first motion does not.
  double begin_of_wave() const {
    float peak = 0.0F;
    for (const float x : mean_) peak = std::max(peak, std::abs(x));
    const auto first = std::find_if(mean_.begin(), mean_.end(), [&](float x) { return std::abs(x) > 0.1F * peak; });
    return static_cast<double>(first - mean_.begin());
  }

  const audio::AudioSource& sound_;
  const std::vector<RoughImpact>& impacts_;
  ImpactTemplate& learned_;
  std::vector<std::size_t> chosen_;
  std::size_t n_window_ = 0;
  std::optional<audio::RealFft> fourier_;
  std::vector<TrainingImpact> training_;
  std::vector<float> mean_;
};

std::vector<float> white(const audio::ArModel& noise) {
  std::vector<float> filter = noise.filter;
  const auto scale = static_cast<float>(1.0 / std::sqrt(noise.quiet_variance));
  for (float& c : filter) c *= scale;
  return filter;
}

}  // namespace

std::optional<ImpactTemplate> estimate_template(const audio::AudioSource& sound, const audio::ArModel& noise,
                                                const std::vector<RoughImpact>& impacts) {
  if (impacts.size() < 3 || !(noise.quiet_variance > 0.0)) return std::nullopt;
  ImpactTemplate learned;
  learned.whitener = white(noise);
  TemplateEstimator learner(sound, impacts, learned);
  learner.read_training_windows();
  learner.find_wave();
  learner.whiten_residuals();
  learner.read_training_windows();
  learner.refine_wave();
  learner.estimate_subbands();
  learner.describe();
  if (learned.n_impacts < 3) return std::nullopt;
  learner.describe_as_heard();
  return learned;
}

double correlation(const DelayEstimate& reading, double total) {
  return std::sqrt(std::min(1.0, 2.0 * reading.log_likelihood_ratio / (total + 1e-30)));
}

}  // namespace bouncelab::detection
