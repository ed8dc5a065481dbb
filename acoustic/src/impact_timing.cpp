// SPDX-License-Identifier: GPL-3.0-or-later
#include "impact_timing.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "products.hpp"

namespace bouncelab {
namespace {

constexpr double kWave_s = 15e-3;     // holds more than nine tenths of what a plate's sound says of its time
constexpr double kBefore_s = 0.5e-3;  // quiet part in front of the rough time
constexpr double kSearch_s = 1e-3;    // error of the rough times
constexpr std::size_t kMostLearned = 48;
constexpr int kRounds = 3;
constexpr std::size_t kResidualOrder = 32;
constexpr double kAmbiguous = 1e-3;  // odds of another place that are worth a flag
constexpr double kLeastCorrelation = 0.5;

std::int64_t samples(double duration_s, const Sound& sound) { return std::llround(duration_s * sound.rate_hz); }

std::vector<float> read_whitened(const Sound& sound, const std::vector<float>& whitener, std::int64_t first,
                                 std::size_t n) {
  std::vector<float> out(n);
  read_innovations(sound, {whitener, 0.0}, first, out);
  return out;
}

/// One impact to learn from.
struct Row {
  std::int64_t first = 0;    // sample at which the stretch begins
  std::vector<float> sound;  // whitened
  double position = 0.0;     // of the wave's first sample within the stretch
  double amplitude = 1.0;
  double correlation = 1.0;
};

/// Strong impacts that ring alone; where none does, the strong ones.
std::vector<std::size_t> choose_rows(const std::vector<RoughImpact>& impacts) {
  std::vector<std::size_t> alone;
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    all.push_back(k);
    const bool next_far = k + 1 == impacts.size() || impacts[k + 1].t_s - impacts[k].t_s > kWave_s + 2.0 * kSearch_s;
    const bool last_far = k == 0 || impacts[k].t_s - impacts[k - 1].t_s > kWave_s;
    if (next_far && last_far) alone.push_back(k);
  }
  std::vector<std::size_t>& chosen = alone.size() >= 5 ? alone : all;
  if (chosen.size() > kMostLearned) {
    std::nth_element(chosen.begin(), chosen.begin() + kMostLearned, chosen.end(),
                     [&](std::size_t a, std::size_t b) { return impacts[a].amplitude > impacts[b].amplitude; });
    chosen.resize(kMostLearned);
  }
  std::sort(chosen.begin(), chosen.end(),
            [&](std::size_t a, std::size_t b) { return impacts[a].amplitude > impacts[b].amplitude; });
  return chosen;
}

std::vector<Row> read_rows(const Sound& sound, const std::vector<float>& whitener,
                           const std::vector<RoughImpact>& impacts, const std::vector<std::size_t>& chosen,
                           std::size_t n_wave) {
  const std::int64_t margin = samples(kSearch_s, sound) + static_cast<std::int64_t>(FractionalShift::kReach) + 2;
  std::vector<Row> rows;
  for (const std::size_t k : chosen) {
    Row row;
    row.first = samples(impacts[k].t_s - kBefore_s, sound) - margin;
    row.sound = read_whitened(sound, whitener, row.first, n_wave + 2 * static_cast<std::size_t>(margin));
    row.position = static_cast<double>(margin);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The wave as this row has it, at its position.
std::vector<float> aligned(const Row& row, std::size_t n_wave) {
  std::vector<float> out(n_wave);
  const double whole = std::floor(row.position);
  const auto begin = static_cast<std::size_t>(whole) - FractionalShift::kReach;
  FractionalShift(row.position - whole)
      .apply(std::span(row.sound).subspan(begin, n_wave + 2 * FractionalShift::kReach), out);
  return out;
}

/// Average of the rows that sound alike, each as heavy as its amplitude.
std::vector<float> average(const std::vector<Row>& rows, std::size_t n_wave) {
  std::vector<double> sum(n_wave, 0.0);
  double weight = 0.0;
  for (const Row& row : rows) {
    if (row.correlation < kLeastCorrelation) continue;
    const std::vector<float> y = aligned(row, n_wave);
    for (std::size_t n = 0; n < n_wave; ++n) sum[n] += row.amplitude * y[n];
    weight += row.amplitude * row.amplitude;
  }
  std::vector<float> mean(n_wave);
  for (std::size_t n = 0; n < n_wave; ++n) mean[n] = weight > 0.0 ? static_cast<float>(sum[n] / weight) : 0.0F;
  return mean;
}

void align_rows(std::vector<Row>& rows, const WaveTemplate& wave, const Sound& sound, bool search) {
  const auto margin = static_cast<std::ptrdiff_t>(FractionalShift::kReach) + 2;
  const std::ptrdiff_t reach = 2 * samples(kSearch_s, sound);
  for (Row& row : rows) {
    double start = row.position;
    if (search) start = wave.search(row.sound, margin, margin + reach, wave.size()).shift;
    const WaveFit fit = wave.fit(row.sound, start, wave.size());
    const double limit = static_cast<double>(row.sound.size() - wave.size()) - static_cast<double>(margin);
    row.position = std::clamp(fit.shift, static_cast<double>(margin), limit);
    row.amplitude = std::max(fit.amplitude, 1e-6);
    const double explained = 2.0 * fit.gain;
    row.correlation = std::sqrt(explained / (explained + fit.misfit * static_cast<double>(wave.size()) + 1e-30));
  }
}

double median(std::vector<double> x) {
  if (x.empty()) return 0.0;
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

/// Where the wave begins: the first sample above a tenth of the peak. Noise and the forerunners of a linear-phase
/// converter stay below; a plate's first motion does not.
double begin_of(const std::vector<float>& mean, std::size_t n_search) {
  const auto end = mean.begin() + static_cast<std::ptrdiff_t>(std::min(n_search, mean.size()));
  float peak = 0.0F;
  for (auto x = mean.begin(); x != end; ++x) peak = std::max(peak, std::abs(*x));
  const auto first = std::find_if(mean.begin(), end, [&](float x) { return std::abs(x) > 0.1F * peak; });
  return static_cast<double>(first - mean.begin());
}

std::vector<float> white(const Autoregression& noise) {
  std::vector<float> filter = noise.filter;
  const auto scale = static_cast<float>(1.0 / std::sqrt(noise.quiet_variance));
  for (float& c : filter) c *= scale;
  return filter;
}

/// What the wave leaves of a row.
std::vector<float> residual(const Row& row, const WaveTemplate& wave) {
  std::vector<float> x = row.sound;
  wave.subtract(x, row.position, row.amplitude);
  return x;
}

/// A filter that also makes white what the wave does not explain: noise where that is all, the ringing of modes that
/// are struck differently each time where the recording is cleaner than the wave is constant.
std::vector<float> whiten_residuals(const std::vector<float>& whitener, const std::vector<Row>& rows,
                                    const WaveTemplate& wave) {
  std::vector<double> r(kResidualOrder + 1, 0.0);
  for (const Row& row : rows) {
    const std::vector<float> x = residual(row, wave);
    const double energy = dot(x, x);
    for (std::size_t lag = 0; lag <= kResidualOrder; ++lag) r[lag] += dot(x, std::span(x).subspan(lag)) / energy;
  }
  const std::vector<double> a = prediction_error_filter(r);
  std::vector<float> both(whitener.size() + kResidualOrder, 0.0F);
  for (std::size_t j = 0; j < whitener.size(); ++j)
    for (std::size_t k = 0; k <= kResidualOrder; ++k) both[j + k] += whitener[j] * static_cast<float>(a[k]);
  return both;
}

/// The mean of the rows as recorded, and how much they differ from it.
void describe_as_heard(const Sound& sound, const std::vector<Row>& rows, std::size_t n_wave, ImpactWave& learned) {
  constexpr std::size_t kReach = FractionalShift::kReach;
  std::vector<double> sum(n_wave, 0.0);
  std::vector<double> squares(n_wave, 0.0);
  std::vector<float> x(n_wave + 2 * kReach);
  std::vector<float> y(n_wave);
  double n = 0.0;
  const auto n_quiet = std::max<std::size_t>(1, static_cast<std::size_t>(learned.contact_index));
  for (const Row& row : rows) {
    if (row.correlation < kLeastCorrelation) continue;
    const double whole = std::floor(row.position);
    read_padded(sound, row.first + static_cast<std::int64_t>(whole) - static_cast<std::int64_t>(kReach), x);
    FractionalShift(row.position - whole).apply(x, y);
    const double level = std::accumulate(y.begin(), y.begin() + static_cast<std::ptrdiff_t>(n_quiet), 0.0) /
                         static_cast<double>(n_quiet);
    for (std::size_t k = 0; k < n_wave; ++k) {
      const double value = (y[k] - level) / row.amplitude;
      sum[k] += value;
      squares[k] += value * value;
    }
    n += 1.0;
  }
  learned.heard.resize(n_wave);
  learned.spread.resize(n_wave);
  for (std::size_t k = 0; k < n_wave; ++k) {
    learned.heard[k] = sum[k] / n;
    learned.spread[k] = std::sqrt(std::max(0.0, squares[k] / n - learned.heard[k] * learned.heard[k]));
    learned.peak = std::max(learned.peak, std::abs(learned.heard[k]));
  }
}

struct Learning {
  std::vector<Row> rows;
  std::vector<float> mean;
};

/// Rounds of aligning and averaging.
/// @param before  an earlier learning of the same impacts; without one, from the strongest row
Learning align_and_average(const Sound& sound, const std::vector<float>& whitener,
                           const std::vector<RoughImpact>& impacts, const std::vector<std::size_t>& chosen,
                           std::size_t n_wave, const Learning* before) {
  Learning l;
  l.rows = read_rows(sound, whitener, impacts, chosen, n_wave);
  if (before != nullptr) {
    for (std::size_t k = 0; k < l.rows.size(); ++k) {
      l.rows[k].position = before->rows[k].position;
      l.rows[k].amplitude = before->rows[k].amplitude;
      l.rows[k].correlation = before->rows[k].correlation;
    }
    l.mean = average(l.rows, n_wave);
  } else {
    l.mean = aligned(l.rows.front(), n_wave);
  }
  const int n_search = before == nullptr ? 2 : 1;  // the new whitener may have cleared up what was ambiguous
  for (int round = 0; round < kRounds; ++round) {
    align_rows(l.rows, WaveTemplate(l.mean), sound, round < n_search);
    l.mean = average(l.rows, n_wave);
  }
  return l;
}

}  // namespace

std::optional<ImpactWave> learn_impact_wave(const Sound& sound, const Autoregression& noise,
                                            const std::vector<RoughImpact>& impacts) {
  if (impacts.size() < 3 || !(noise.quiet_variance > 0.0)) return std::nullopt;
  const auto n_wave = static_cast<std::size_t>(samples(kBefore_s + kWave_s, sound));
  ImpactWave learned;
  learned.whitener = white(noise);
  const std::vector<std::size_t> chosen = choose_rows(impacts);
  Learning l = align_and_average(sound, learned.whitener, impacts, chosen, n_wave, nullptr);
  learned.whitener = whiten_residuals(learned.whitener, l.rows, WaveTemplate(l.mean));
  const Learning first = std::move(l);
  l = align_and_average(sound, learned.whitener, impacts, chosen, n_wave, &first);
  learned.wave = WaveTemplate(l.mean);
  std::vector<double> correlations;
  for (const Row& row : l.rows) {
    correlations.push_back(row.correlation);
    if (row.correlation >= kLeastCorrelation) ++learned.n_impacts;
  }
  learned.correlation = median(correlations);
  learned.contact_index = begin_of(l.mean, static_cast<std::size_t>(samples(kBefore_s + 3e-3, sound)));
  if (learned.n_impacts < 3) return std::nullopt;
  describe_as_heard(sound, l.rows, n_wave, learned);
  return learned;
}

TimedImpact ImpactTimer::time(double t_s, double reach_s, double until_s) const {
  const ImpactWave& w = wave_;
  const std::int64_t reach = samples(reach_s, sound_) + 2;
  const auto contact = static_cast<std::int64_t>(w.contact_index);
  const std::int64_t first = samples(t_s, sound_) - contact - reach;
  const auto n_fit = static_cast<std::size_t>(std::clamp<std::int64_t>(
      contact + samples(until_s - t_s - reach_s, sound_), contact + 8, static_cast<std::int64_t>(w.wave.size())));
  std::vector<float> x = read_whitened(sound_, w.whitener, first, n_fit + 2 * static_cast<std::size_t>(reach) + 1);
  for (std::size_t j = heard_.size(); j-- > 0;) {
    const double begin = heard_[j].t_s * sound_.rate_hz - w.contact_index - static_cast<double>(first);
    if (begin + static_cast<double>(w.wave.size()) <= 0.0) break;
    w.wave.subtract(x, begin, heard_[j].amplitude);
  }
  const WavePlace place = w.wave.search(x, 0, 2 * reach, n_fit);
  const WaveFit fit = w.wave.fit(x, place.shift, n_fit);
  TimedImpact t;
  t.t_s = (static_cast<double>(first) + fit.shift + w.contact_index) / sound_.rate_hz;
  t.sigma_s = fit.sigma_shift * std::sqrt(fit.misfit) / sound_.rate_hz;
  // two places, odds exp(-lead): what the other adds to the variance; the misfit is not quite white, hence half the
  // lead
  const double odds = std::exp(-0.5 * place.lead / std::max(1.0, fit.misfit));
  t.ambiguous = odds > kAmbiguous;
  t.sigma_s = std::hypot(t.sigma_s, std::sqrt(odds) / (1.0 + odds) * (place.runner_up - place.shift) / sound_.rate_hz);
  t.amplitude = fit.amplitude;
  t.gain = fit.gain;
  t.misfit = fit.misfit;
  const double explained = 2.0 * fit.gain;
  t.correlation = std::sqrt(explained / (explained + fit.misfit * static_cast<double>(n_fit) + 1e-30));
  return t;
}

void ImpactTimer::remember(const TimedImpact& impact) {
  if (impact.amplitude > 0.0) heard_.push_back(impact);
}

}  // namespace bouncelab
