// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/renderer.hpp"

#include <algorithm>
#include <span>
#include <utility>

namespace bouncelab::synthesis {
namespace {

/// A resonator is set to zero when it is below the last of 32 bits, or 80 dB below the noise.
constexpr double kSilence = 1e-11, kSilenceInNoise = 1e-4;
constexpr std::int64_t kBlock = ResonatorBank::kBlock;

void add_to(PoleValues& sum, const PoleValues& part) {
  for (std::size_t p = 0; p < sum.size(); ++p) sum.set(p, sum[p] + part[p]);
}

/// 2.5 s: long against the plate's memory, of which each segment computes the beginning anew.
std::int64_t frames_of_a_segment(int rate_hz) {
  return std::max<std::int64_t>(1 << 16, std::int64_t{rate_hz} * 5 / 2 / kBlock * kBlock);
}

}  // namespace

Renderer::Renderer(const SynthesisConfig& config, const StrikeSound& sound, const Schedule& schedule,
                   const Levels& levels)
    : config_(config),
      sound_(sound),
      schedule_(schedule),
      levels_(levels),
      background_(config, schedule, sound.instrument().bank().filter(), levels),
      segment_frames_(frames_of_a_segment(config.rate_hz)),
      reach_back_s_(static_cast<double>(sound.instrument().bank().memory_frames() +
                                        sound.instrument().tail().memory_frames() + kBlock) /
                        config.rate_hz +
                    sound.largest_delay_s()),
      reach_ahead_s_((ConverterFilter::kHalfWidth_samples + 4.0) / config.rate_hz),
      silence_(std::max(kSilence, kSilenceInNoise * levels.noise_rms)) {}

template <class Use>
void Renderer::for_each_contact(std::size_t channel, const Strike& strike, const Use& use) const {
  const StrikeSound::Wave wave = sound_.wave_at(channel, strike);
  Contact direct = sound_.contact(channel, strike);
  direct.impulse *= levels_.gain;
  use(direct, wave);
  for (const Echo& echo : config_.sensor.echoes) {
    Contact late = direct;
    late.arrival_samples += echo.delay_s * config_.rate_hz;
    late.impulse *= echo.gain;
    use(late, wave);
  }
}

std::vector<double> Renderer::strikes_sound(std::size_t channel, std::int64_t first, std::int64_t n) const {
  const ResonatorBank& bank = sound_.instrument().bank();
  const std::int64_t n_blocks = (n + kBlock - 1) / kBlock, end = first + n_blocks * kBlock;
  std::vector<double> out(static_cast<std::size_t>(n_blocks * kBlock), 0.0);
  PoleValues state(bank.size());
  std::vector<std::pair<std::int64_t, PoleValues>> joining;  // block at whose begin a wave joins the free ringing

  const auto add_contact = [&](const Contact& contact, const StrikeSound::Wave& wave_of) {
    if (contact.arrival_samples - ConverterFilter::kHalfWidth_samples >= static_cast<double>(end)) return;
    ContactWave wave = wave_of(contact, false);
    if (wave.end() <= first) {
      bank.advance(wave.ringing, first - wave.end());
      add_to(state, wave.ringing);
      return;
    }
    for (std::int64_t k = std::max(wave.first, first); k < std::min(wave.end(), end); ++k)
      out[static_cast<std::size_t>(k - first)] += wave.samples[static_cast<std::size_t>(k - wave.first)];
    if (wave.end() < end) joining.emplace_back((wave.end() - first) / kBlock, std::move(wave.ringing));
  };
  const double earliest_s =
      static_cast<double>(first - bank.memory_frames()) / config_.rate_hz - sound_.largest_delay_s();
  const double latest_s = static_cast<double>(end) / config_.rate_hz + reach_ahead_s_;
  auto strike = std::lower_bound(schedule_.strikes.begin(), schedule_.strikes.end(), earliest_s,
                                 [](const Strike& s, double t_s) { return s.t_s < t_s; });
  for (; strike != schedule_.strikes.end() && strike->t_s < latest_s; ++strike)
    for_each_contact(channel, *strike, add_contact);
  ring(joining, state, out);
  out.resize(static_cast<std::size_t>(n));
  return out;
}

void Renderer::ring(std::vector<std::pair<std::int64_t, PoleValues>>& joining, PoleValues& state,
                    std::span<double> out) const {
  std::stable_sort(joining.begin(), joining.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto n_blocks = static_cast<std::int64_t>(out.size()) / kBlock;
  auto next = joining.begin();
  for (std::int64_t block = 0; block < n_blocks;) {
    for (; next != joining.end() && next->first == block; ++next) add_to(state, next->second);
    const std::int64_t until = next == joining.end() ? n_blocks : next->first;
    const auto at = static_cast<std::size_t>(block * kBlock),
               length = static_cast<std::size_t>((until - block) * kBlock);
    sound_.instrument().bank().ring(state, silence_, out.subspan(at, length));
    block = until;
  }
}

/// As strikes_sound, with the reverberation tail, begun so early that its start has decayed.
std::vector<double> Renderer::reverberant_sound(std::size_t channel, std::int64_t first, std::int64_t n) const {
  const ReverberationTail& tail = sound_.instrument().tail();
  const std::int64_t run_in = (tail.memory_frames() + kBlock - 1) / kBlock * kBlock;
  std::vector<double> sound = strikes_sound(channel, first - run_in, n + run_in);
  tail.add_to(sound);
  sound.erase(sound.begin(), sound.begin() + run_in);
  return sound;
}

std::vector<double> Renderer::frames(std::int64_t first, std::int64_t n) const {
  const std::size_t n_channels = config_.channels.size();
  std::vector<double> interleaved(n_channels > 1 ? static_cast<std::size_t>(n) * n_channels : 0);
  for (std::size_t c = 0; c < n_channels; ++c) {
    std::vector<double> sound = config_.channels[c].gain == 0.0 ? std::vector<double>(static_cast<std::size_t>(n), 0.0)
                                                                : reverberant_sound(c, first, n);
    background_.add(c, first, sound);
    for (double& sample : sound) sample = std::clamp(sample, -1.0, 1.0);
    if (n_channels == 1) return sound;
    for (std::size_t k = 0; k < sound.size(); ++k) interleaved[k * n_channels + c] = sound[k];
  }
  return interleaved;
}

}  // namespace bouncelab::synthesis
