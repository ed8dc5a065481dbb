// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/background.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::synthesis {
namespace {

constexpr std::uint32_t kMultiplier[2] = {0xD2511F53U, 0xCD9E8D57U};
constexpr std::uint32_t kKeyStep[2] = {0x9E3779B9U, 0xBB67AE85U};
constexpr int kRounds = 10;
constexpr auto kStream = static_cast<std::uint32_t>(RandomStream::noise);

/// Round by round for all blocks, so that no round waits for the one before.
/// @param a, b, c, d  the words of each block
BOUNCELAB_VECTOR_CLONES void draw_words(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block,
                                        std::uint32_t* __restrict a, std::uint32_t* __restrict b,
                                        std::uint32_t* __restrict c, std::uint32_t* __restrict d) {
  for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
    a[k] = static_cast<std::uint32_t>(first_block + k);
    b[k] = static_cast<std::uint32_t>((first_block + k) >> 32);
    c[k] = source;
    d[k] = kStream;
  }
  auto lower_key = static_cast<std::uint32_t>(seed), upper_key = static_cast<std::uint32_t>(seed >> 32);
  for (int round = 0; round < kRounds; ++round, lower_key += kKeyStep[0], upper_key += kKeyStep[1])
    for (std::size_t k = 0; k < NoiseWords::kBlocks; ++k) {
      const std::uint64_t p = std::uint64_t{a[k]} * kMultiplier[0], q = std::uint64_t{c[k]} * kMultiplier[1];
      a[k] = static_cast<std::uint32_t>(q >> 32) ^ b[k] ^ lower_key;
      b[k] = static_cast<std::uint32_t>(q);
      c[k] = static_cast<std::uint32_t>(p >> 32) ^ d[k] ^ upper_key;
      d[k] = static_cast<std::uint32_t>(p);
    }
}

/// Blocks of words that make samples in a row: the first coordinates of as many points, the second ones, then those of
/// each block's other point.
constexpr std::size_t kPairs = 16;
constexpr std::size_t kNoiseRow = 4 * kPairs;

/// log u to 1 unit in the last place, u > 0 and normal: Cephes' logf (S. L. Moshier), without branches.
[[gnu::always_inline]] inline float log_of(float u) {
  constexpr std::uint32_t kSqrtHalf = 0x3f3504f3U, kMantissa = 0x007fffffU;
  const std::uint32_t above = bouncelab::bit_cast<std::uint32_t>(u) - kSqrtHalf;
  const auto exponent = static_cast<float>(static_cast<std::int32_t>(above) >> 23);
  const float x = bouncelab::bit_cast<float>((above & kMantissa) + kSqrtHalf) - 1.0F, z = x * x;
  float p = 7.0376836292e-2F;
  p = p * x - 1.1514610310e-1F;
  p = p * x + 1.1676998740e-1F;
  p = p * x - 1.2420140846e-1F;
  p = p * x + 1.4249322787e-1F;
  p = p * x - 1.6668057665e-1F;
  p = p * x + 2.0000714765e-1F;
  p = p * x - 2.4999993993e-1F;
  p = p * x + 3.3333331174e-1F;
  const float small = (x * z * p + exponent * -2.12194440e-4F) - 0.5F * z;
  return (x + small) + exponent * 0.693359375F;
}

/// sqrt(-2 log u), u from the upper 31 bits.
[[gnu::always_inline]] inline float radius_of(std::uint32_t word) {
  const float u = (static_cast<float>(static_cast<std::int32_t>(word >> 1)) + 0.5F) * 0x1p-31F;
  return std::sqrt(-2.0F * log_of(u));
}

/// A point at this radius, in a direction from 32 bits: 30 for an angle in [-pi/4, pi/4), of which sine and cosine are
/// Cephes' polynomials; one exchanges them; one turns the point by half a circle.
[[gnu::always_inline]] inline void point_of(float radius, std::uint32_t word, float& x, float& y) {
  constexpr std::uint32_t kSign = 0x80000000U, kExchange = 0x40000000U;
  constexpr auto kQuarterPi = static_cast<float>(0.25 * std::numbers::pi * 0x1p-31);
  const float a = static_cast<float>(static_cast<std::int32_t>(word << 2)) * kQuarterPi, z = a * a;
  const float sine = a + a * z * ((-1.9515295891e-4F * z + 8.3321608736e-3F) * z - 1.6666654611e-1F);
  const float cosine =
      (1.0F - 0.5F * z) + z * z * ((2.443315711809948e-5F * z - 1.388731625493765e-3F) * z + 4.166664568298827e-2F);
  const bool is_exchanged = (word & kExchange) != 0;
  const float signed_radius = bouncelab::bit_cast<float>(bouncelab::bit_cast<std::uint32_t>(radius) ^ (word & kSign));
  x = signed_radius * (is_exchanged ? sine : cosine);
  y = signed_radius * (is_exchanged ? cosine : sine);
}

/// Box and Muller's transform of blocks of four words: two points, whose coordinates are samples kPairs apart.
BOUNCELAB_VECTOR_CLONES void transform(const NoiseWords& words, float* samples) {
  for (std::size_t first = 0; first < NoiseWords::kBlocks; first += kPairs)
    for (std::size_t half = 0; half < 2; ++half) {
      const std::uint32_t *of_radius = words.word[2 * half] + first, *of_angle = words.word[2 * half + 1] + first;
      float* x = samples + 4 * first + 2 * half * kPairs;
      for (std::size_t k = 0; k < kPairs; ++k) point_of(radius_of(of_radius[k]), of_angle[k], x[k], x[kPairs + k]);
    }
}

void add_scaled(const float* x, double factor, std::size_t n, double* out) {
  for (std::size_t k = 0; k < n; ++k) out[k] += factor * static_cast<double>(x[k]);
}
void add_scaled(const float* x, double factor, std::size_t n, float* out) {
  const auto single = static_cast<float>(factor);
  for (std::size_t k = 0; k < n; ++k) out[k] += single * x[k];
}

}  // namespace

void NoiseWords::draw(std::uint64_t seed, std::uint32_t source, std::uint64_t first_block) {
  draw_words(seed, source, first_block, word[0], word[1], word[2], word[3]);
}

template <class T>
void WhiteNoise::add_to(std::int64_t first_frame, double rms, std::span<T> out) const {
  constexpr auto kInRow = static_cast<std::int64_t>(kNoiseRow),
                 kAtOnce = static_cast<std::int64_t>(NoiseWords::kFrames);
  std::int64_t frame = (first_frame >= 0 ? first_frame : first_frame - (kInRow - 1)) / kInRow * kInRow;
  auto skipped = static_cast<std::size_t>(first_frame - frame);
  NoiseWords words;
  std::array<float, NoiseWords::kFrames> samples;
  for (std::size_t k = 0; k < out.size(); frame += kAtOnce, skipped = 0) {
    words.draw(seed_, static_cast<std::uint32_t>(source_), static_cast<std::uint64_t>(frame / kInRow) * kPairs);
    transform(words, samples.data());
    const std::size_t n = std::min(samples.size() - skipped, out.size() - k);
    add_scaled(samples.data() + skipped, rms, n, out.data() + k);
    k += n;
  }
}

void WhiteNoise::add(std::int64_t first_frame, double rms, std::span<double> out) const {
  add_to(first_frame, rms, out);
}
void WhiteNoise::add(std::int64_t first_frame, double rms, std::span<float> out) const {
  add_to(first_frame, rms, out);
}

FlickerFilter::FlickerFilter(double corner_hz, double rate_hz) {
  // a pole and then a zero half a ratio above it: -20 dB a decade half of the time, -10 dB on average
  constexpr double kLowest_hz = 5.0, kRatio = 4.0;
  const auto discrete = [rate_hz](double frequency_hz) {
    return exp(-2.0 * std::numbers::pi * frequency_hz / rate_hz);
  };
  for (double f = kLowest_hz; f < corner_hz; f *= kRatio) {
    poles_.push_back(discrete(f));
    zeros_.push_back(discrete(f * std::sqrt(kRatio)));
    scale_ *= (1.0 + poles_.back()) / (1.0 + zeros_.back());
  }
  if (poles_.empty()) return;
  memory_frames_ = static_cast<std::int64_t>(log(1e6) * rate_hz / (2.0 * std::numbers::pi * kLowest_hz));
  std::vector<double> response(static_cast<std::size_t>(memory_frames_), 0.0);
  response.front() = 1.0;
  apply(response);
  double energy = 0.0;
  for (const double h : response) energy += h * h;
  rms_ = std::sqrt(energy);
}

void FlickerFilter::cascade(const std::vector<double>& poles, const std::vector<double>& zeros, double scale,
                            std::span<double> samples) {
  for (std::size_t k = 0; k < poles.size(); ++k) {
    double x_before = 0.0, y = 0.0;
    for (double& sample : samples) {
      y = poles[k] * y + sample - zeros[k] * x_before;
      x_before = sample;
      sample = y;
    }
  }
  for (double& sample : samples) sample *= scale;
}

void FlickerFilter::apply(std::span<double> samples) const { cascade(poles_, zeros_, scale_, samples); }

void FlickerFilter::whiten(std::span<double> samples) const { cascade(zeros_, poles_, 1.0 / scale_, samples); }

std::complex<double> FlickerFilter::whitening_gain(std::complex<double> z) const {
  std::complex<double> gain = 1.0 / scale_;
  for (std::size_t k = 0; k < poles_.size(); ++k) gain *= (z - poles_[k]) / (z - zeros_[k]);
  return gain;
}

namespace {

// of the disturbance stream, beside those of schedule.cpp
constexpr std::uint64_t kPhaseItem = 255, kVoiceItem = 253;

/// Adds amplitude sin(2 pi f n / rate + phase) by rotation; started anew in each call, so the error stays below 1e-11.
void add_tone(double frequency_hz, double phase_rad, double amplitude, double rate_hz, std::int64_t first,
              std::span<double> out) {
  const double turns = frequency_hz / rate_hz * static_cast<double>(first);
  double angle = 2.0 * std::numbers::pi * (turns - std::floor(turns)) + phase_rad;
  double re = cos(angle), im = sin(angle);
  const double step_re = cos(2.0 * std::numbers::pi * frequency_hz / rate_hz);
  const double step_im = sin(2.0 * std::numbers::pi * frequency_hz / rate_hz);
  for (double& y : out) {
    y += amplitude * im;
    const double next = re * step_re - im * step_im;
    im = re * step_im + im * step_re;
    re = next;
  }
}

}  // namespace

Background::Background(const SynthesisConfig& config, const Schedule& schedule, const ConverterFilter& filter,
                       const Levels& levels)
    : config_(config),
      schedule_(schedule),
      filter_(filter),
      levels_(levels),
      flicker_(config.noise_corner_hz, config.rate_hz) {}

bool Background::is_white() const {
  const Disturbances& d = config_.disturbances;
  return flicker_.memory_frames() == 0 && d.hum_level <= 0.0 && d.drift_level <= 0.0 && d.clicks_per_s <= 0.0 &&
         d.speech_per_s <= 0.0;
}

void Background::add(std::size_t channel, std::int64_t first, std::span<double> out) const {
  add_noise(channel, first, out);
  add_hum_and_drift(first, out);
  add_clicks(first, out);
  for (const Syllable& syllable : schedule_.syllables) add_syllable(syllable, first, out);
}

void Background::add_noise(std::size_t channel, std::int64_t first, std::span<double> out) const {
  const std::int64_t run_in = flicker_.memory_frames();
  if (run_in == 0) return add_white(channel, first, out);
  std::vector<double> noise(static_cast<std::size_t>(run_in) + out.size(), 0.0);
  WhiteNoise(config_.seed, channel).add(first - run_in, levels_.noise_rms / flicker_.rms(), noise);
  flicker_.apply(noise);
  for (std::size_t k = 0; k < out.size(); ++k) out[k] += noise[static_cast<std::size_t>(run_in) + k];
}

void Background::add_hum_and_drift(std::int64_t first, std::span<double> out) const {
  const Disturbances& d = config_.disturbances;
  Random random(config_.seed, RandomStream::disturbance, kPhaseItem);
  const double rate_hz = config_.rate_hz;
  for (int harmonic = 1; harmonic <= 7; ++harmonic) {
    const double phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    if (d.hum_level > 0.0)
      add_tone(harmonic * d.hum_hz, phase_rad, d.hum_level * levels_.weakest_peak / harmonic, rate_hz, first, out);
  }
  for (const double frequency_hz : {0.067, 0.19, 0.43}) {
    const double phase_rad = random.uniform(0.0, 2.0 * std::numbers::pi);
    if (d.drift_level > 0.0)
      add_tone(frequency_hz, phase_rad, d.drift_level * levels_.weakest_peak / 3.0, rate_hz, first, out);
  }
}

void Background::add_clicks(std::int64_t first, std::span<double> out) const {
  constexpr double kReach = ConverterFilter::kHalfWidth_samples + 2.0;
  const double rate_hz = config_.rate_hz;
  const auto n = static_cast<double>(out.size());
  const auto from = std::lower_bound(schedule_.clicks.begin(), schedule_.clicks.end(),
                                     (static_cast<double>(first) - kReach) / rate_hz,
                                     [](const Click& click, double t_s) { return click.t_s < t_s; });
  for (auto click = from; click != schedule_.clicks.end(); ++click) {
    const double at = click->t_s * rate_hz - static_cast<double>(first);
    if (at - kReach > n) break;
    // up and, 1.5 samples later, half as far down
    const double height = click->level * levels_.weakest_peak;
    filter_.add(-at, height, out);
    filter_.add(-at - 1.5, -0.5 * height, out);
  }
}

/// Source and filter: pulses of the glottis through resonators in cascade. Source: Klatt, J. Acoust. Soc. Am. 67, 971
/// (1980), doi:10.1121/1.383940, eqs. 1 and 2.
std::vector<double> Background::voice(const Syllable& syllable, std::size_t n) const {
  Random random(config_.seed, RandomStream::disturbance, (syllable.number << 8) | kVoiceItem);
  const double pitch_hz = random.uniform(85.0, 240.0), fall = random.uniform(0.10, 0.45);
  const double rate_hz = config_.rate_hz, length = static_cast<double>(n);
  std::vector<double> sound(n, 0.0);
  for (double at = 0.0; at + 1.0 < length; at += rate_hz / (pitch_hz * (1.0 - fall * at / length))) {
    const double sine = sin(std::numbers::pi * at / length), second = at - std::floor(at);
    const auto k = static_cast<std::size_t>(at);  // a pulse between two samples is in both
    sound[k] += (1.0 - second) * sine * sine;
    sound[k + 1] += second * sine * sine;
  }
  struct Formant {
    double lowest_hz, highest_hz, width_hz;
  };
  double peak = 0.0;
  for (const Formant& formant : {Formant{300, 800, 80}, Formant{900, 2200, 120}, Formant{2300, 3200, 200}}) {
    const double keep = exp(-std::numbers::pi * formant.width_hz / rate_hz);
    const double turn_rad = 2.0 * std::numbers::pi * random.uniform(formant.lowest_hz, formant.highest_hz) / rate_hz;
    const double b = 2.0 * keep * cos(turn_rad), c = -keep * keep, a = 1.0 - b - c;
    double before = 0.0, before_that = 0.0;
    peak = 0.0;
    for (double& y : sound) {
      y = a * y + b * before + c * before_that;
      before_that = std::exchange(before, y);
      peak = std::max(peak, std::abs(y));
    }
  }
  for (double& y : sound) y /= peak;
  return sound;
}

void Background::add_syllable(const Syllable& syllable, std::int64_t first, std::span<double> out) const {
  const double rate_hz = config_.rate_hz;
  const auto begin = static_cast<std::int64_t>(std::ceil(syllable.t_s * rate_hz));
  const auto end = static_cast<std::int64_t>((syllable.t_s + syllable.duration_s) * rate_hz);
  const std::int64_t lo = std::max(begin, first), hi = std::min(end, first + static_cast<std::int64_t>(out.size()));
  if (lo >= hi) return;
  const std::vector<double> sound = voice(syllable, static_cast<std::size_t>(end - begin));
  const double length = static_cast<double>(end - begin), level = syllable.level * levels_.weakest_peak;
  for (std::int64_t k = lo; k < hi; ++k) {
    const double share = static_cast<double>(k - begin) / length;
    const double edge = std::min({1.0, share / 0.1, (1.0 - share) / 0.1});
    out[static_cast<std::size_t>(k - first)] += level * edge * sound[static_cast<std::size_t>(k - begin)];
  }
}

}  // namespace bouncelab::synthesis
