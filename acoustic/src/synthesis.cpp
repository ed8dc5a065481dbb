// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/acoustic/synthesis.hpp"

#include <algorithm>
#include <cmath>

#include "background.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/random.hpp"
#include "in_parallel.hpp"
#include "instrument.hpp"
#include "schedule.hpp"
#include "synthesis_checks.hpp"

namespace bouncelab {
namespace {

/// Below this a resonator is silent: under the last bit of 32.
constexpr double kSilence = 1e-11;

}  // namespace

std::shared_ptr<const Instrument> make_instrument(const SynthesisConfig& config) {
  validate(config);
  return std::make_shared<const Instrument>(config.ground, config.sensor, config.channels, config.rate_hz,
                                            std::min(config.max_mode_hz, 0.5 * config.rate_hz));
}

struct SyntheticRecording::State {
  SynthesisConfig config;
  std::shared_ptr<const Instrument> instrument;
  Schedule schedule;
  std::vector<TrueImpact> truth;
  Levels levels;
  std::unique_ptr<Background> background;
  std::int64_t n_frames = 0;
  std::int64_t segment_frames = 0;
  double largest_delay_s = 0.0;  // travel, echo and contact

  PoleValues amplitudes(std::size_t channel, const Strike& strike) const;
  Contact contact(std::size_t channel, const Strike& strike) const;
  void measure(const Impacts& impacts);
  void choose_levels();
  std::vector<double> strikes_sound(std::size_t channel, std::int64_t first, std::int64_t n) const;
  std::vector<double> sound_in_room(std::size_t channel, std::int64_t first, std::int64_t n) const;
  template <class Use>
  void for_each_contact(std::size_t channel, const Strike& strike, const Use& use) const;
};

PoleValues SyntheticRecording::State::amplitudes(std::size_t channel, const Strike& strike) const {
  std::vector<double> shapes = instrument->shapes_under_ball(strike.x_m, strike.y_m);
  const Disturbances& d = config.disturbances;
  Random random(config.seed, RandomStream::plate, (1ull << 63) | static_cast<std::uint64_t>(strike.impact_index + 1));
  if (d.timbre_wander > 0.0)
    for (double& shape : shapes) shape *= std::exp(d.timbre_wander * random.normal());
  PoleValues result = instrument->amplitudes(channel, shapes);
  if (d.phase_wander_rad > 0.0)
    for (std::size_t k = 0; k < shapes.size(); ++k)
      result.set(k, result[k] * std::polar(1.0, d.phase_wander_rad * random.normal()));
  return result;
}

Contact SyntheticRecording::State::contact(std::size_t channel, const Strike& strike) const {
  const double arrival_s = strike.t_s + instrument->travel_time_s(channel, strike.x_m, strike.y_m);
  return {arrival_s * config.rate_hz, strike.duration_s * config.rate_hz, strike.impulse_ns};
}

void SyntheticRecording::State::measure(const Impacts& impacts) {
  const auto alive = std::find_if(config.channels.begin(), config.channels.end(),
                                  [](const Channel& channel) { return channel.gain != 0.0; });
  const auto channel = static_cast<std::size_t>(alive - config.channels.begin());
  std::vector<const Strike*> hits;
  for (const Strike& strike : schedule.strikes)
    if (strike.impact_index >= 0) hits.push_back(&strike);
  truth.resize(hits.size());
  const FlickerFilter noise(config.noise_corner_hz, config.rate_hz);
  in_parallel(hits.size(), resolved_threads(config.n_threads), [&](std::size_t k) {
    const Strike& strike = *hits[k];
    const WaveMeasure wave = instrument->meter().measure(contact(channel, strike), amplitudes(channel, strike), noise);
    const Impact& impact = impacts.rows[static_cast<std::size_t>(strike.impact_index)];
    TrueImpact& row = truth[k];
    row.drop = impact.drop;
    row.impact = impact.impact;
    row.t_s = strike.t_s;
    // for noise of rms 1 and gain 1
    row.sigma_t_s = 1.0 / (noise.rms() * config.rate_hz * std::sqrt(wave.slope_energy));
    row.amplitude = wave.peak;
    row.contact_time_s = strike.duration_s;
    row.travel_time_s = instrument->travel_time_s(channel, strike.x_m, strike.y_m);
    row.x_m = strike.x_m;
    row.y_m = strike.y_m;
    row.v_mps = impact.v_mps;
  });
}

void SyntheticRecording::State::choose_levels() {
  const auto [weakest, strongest] = std::minmax_element(
      truth.begin(), truth.end(), [](const auto& a, const auto& b) { return a.amplitude < b.amplitude; });
  if (config.levels) {
    levels = *config.levels;
  } else {
    levels.gain = config.peak / strongest->amplitude;
    levels.weakest_peak = weakest->amplitude * levels.gain;
    levels.noise_rms = levels.weakest_peak * std::pow(10.0, -config.snr_db / 20.0);
  }
  for (TrueImpact& row : truth) {
    row.amplitude *= levels.gain;
    row.sigma_t_s *= levels.noise_rms / levels.gain;
    row.snr_db = 20.0 * std::log10(row.amplitude / levels.noise_rms);
    if (row.amplitude > 1.0) row.flags = "clipped";
  }
}

template <class Use>
void SyntheticRecording::State::for_each_contact(std::size_t channel, const Strike& strike, const Use& use) const {
  const PoleValues sounds = amplitudes(channel, strike);
  Contact heard = contact(channel, strike);
  heard.impulse *= levels.gain;
  use(heard, sounds);
  for (const Echo& echo : config.sensor.echoes) {
    Contact late = heard;
    late.arrival_samples += echo.delay_s * config.rate_hz;
    late.impulse *= echo.gain;
    use(late, sounds);
  }
}

std::vector<double> SyntheticRecording::State::strikes_sound(std::size_t channel, std::int64_t first,
                                                             std::int64_t n) const {
  constexpr std::int64_t kBlock = ResonatorBank::kBlock;
  const ResonatorBank& bank = instrument->bank();
  const std::int64_t n_blocks = (n + kBlock - 1) / kBlock, end = first + n_blocks * kBlock;
  std::vector<double> out(static_cast<std::size_t>(n_blocks * kBlock), 0.0);
  PoleValues state(bank.size());
  std::vector<std::pair<std::int64_t, PoleValues>> joining;  // block at whose begin a wave joins the free ringing

  const auto add_state = [](PoleValues& sum, const PoleValues& part) {
    for (std::size_t p = 0; p < sum.size(); ++p) sum.set(p, sum[p] + part[p]);
  };
  const auto add_contact = [&](const Contact& heard, const PoleValues& sounds) {
    constexpr double kReach = ConverterFilter::kHalfWidth_samples;
    if (heard.arrival_samples - kReach >= static_cast<double>(end)) return;
    ContactWave wave = bank.wave(heard, sounds, false);
    if (wave.end() <= first) {
      bank.advance(wave.ringing, first - wave.end());
      add_state(state, wave.ringing);
      return;
    }
    for (std::int64_t k = std::max(wave.first, first); k < std::min(wave.end(), end); ++k)
      out[static_cast<std::size_t>(k - first)] += wave.samples[static_cast<std::size_t>(k - wave.first)];
    if (wave.end() < end) joining.emplace_back((wave.end() - first) / kBlock, std::move(wave.ringing));
  };

  const double earliest_s = static_cast<double>(first - bank.memory_frames()) / config.rate_hz - largest_delay_s;
  const double latest_s = static_cast<double>(end) / config.rate_hz + 1e-3;
  auto strike = std::lower_bound(schedule.strikes.begin(), schedule.strikes.end(), earliest_s,
                                 [](const Strike& s, double t_s) { return s.t_s < t_s; });
  for (; strike != schedule.strikes.end() && strike->t_s < latest_s; ++strike)
    for_each_contact(channel, *strike, add_contact);

  std::stable_sort(joining.begin(), joining.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  constexpr std::int64_t kRun = 16;  // blocks rung in one go: they fit the first-level cache
  auto next = joining.begin();
  for (std::int64_t block = 0; block < n_blocks;) {
    for (; next != joining.end() && next->first == block; ++next) add_state(state, next->second);
    const std::int64_t until = std::min({block + kRun, n_blocks, next == joining.end() ? n_blocks : next->first});
    const auto at = static_cast<std::size_t>(block * kBlock),
               length = static_cast<std::size_t>((until - block) * kBlock);
    bank.ring(state, kSilence, std::span(out).subspan(at, length));
    block = until;
  }
  out.resize(static_cast<std::size_t>(n));
  return out;
}

/// As strikes_sound, with the room's tail: begun early enough that the tail has forgotten its start.
std::vector<double> SyntheticRecording::State::sound_in_room(std::size_t channel, std::int64_t first,
                                                             std::int64_t n) const {
  constexpr std::int64_t kBlock = ResonatorBank::kBlock;
  const ReverberationTail& tail = instrument->tail();
  const std::int64_t run_in = (tail.memory_frames() + kBlock - 1) / kBlock * kBlock;
  std::vector<double> sound = strikes_sound(channel, first - run_in, n + run_in);
  tail.add_to(sound);
  sound.erase(sound.begin(), sound.begin() + run_in);
  return sound;
}

SyntheticRecording::SyntheticRecording(const Impacts& impacts, const SynthesisConfig& config,
                                       std::shared_ptr<const Instrument> instrument)
    : state_(std::make_unique<State>()) {
  validate(config);
  validate(impacts, config);
  State& s = *state_;
  s.config = config;
  s.instrument = instrument ? std::move(instrument) : make_instrument(config);
  s.schedule = make_schedule(impacts, config);
  for (const Strike& strike : s.schedule.strikes) check_contact(strike.duration_s, config);
  s.measure(impacts);
  s.choose_levels();
  s.background = std::make_unique<Background>(s.config, s.schedule, s.instrument->bank().filter(), s.levels);
  s.n_frames = static_cast<std::int64_t>(std::ceil(s.schedule.duration_s * config.rate_hz));
  // 2.5 s: long against the plate's memory, which each segment has to recall
  s.segment_frames =
      std::max<std::int64_t>(1 << 16, config.rate_hz * 5 / 2 / ResonatorBank::kBlock * ResonatorBank::kBlock);
  const RectangularPlate& plate = config.ground.carrier;
  for (std::size_t c = 0; c < config.channels.size(); ++c)
    s.largest_delay_s =
        std::max(s.largest_delay_s, s.instrument->travel_time_s(c, -0.5 * plate.length_x_m, -0.5 * plate.length_y_m) +
                                        s.instrument->travel_time_s(c, 0.5 * plate.length_x_m, 0.5 * plate.length_y_m));
  double largest_echo_s = 0.0;
  for (const Echo& echo : config.sensor.echoes) largest_echo_s = std::max(largest_echo_s, echo.delay_s);
  s.largest_delay_s += largest_echo_s + 1e-3;
}

SyntheticRecording::~SyntheticRecording() = default;
SyntheticRecording::SyntheticRecording(SyntheticRecording&&) noexcept = default;
SyntheticRecording& SyntheticRecording::operator=(SyntheticRecording&&) noexcept = default;

std::int64_t SyntheticRecording::n_frames() const { return state_->n_frames; }
const std::vector<TrueImpact>& SyntheticRecording::truth() const { return state_->truth; }
const std::vector<OtherSound>& SyntheticRecording::others() const { return state_->schedule.others; }
const Levels& SyntheticRecording::levels() const { return state_->levels; }
std::int64_t SyntheticRecording::segment_frames() const { return state_->segment_frames; }

std::int64_t SyntheticRecording::n_segments() const {
  return (state_->n_frames + state_->segment_frames - 1) / state_->segment_frames;
}

std::vector<double> SyntheticRecording::segment(std::int64_t index) const {
  const State& s = *state_;
  const std::int64_t first = index * s.segment_frames;
  const std::int64_t n = std::min(s.segment_frames, s.n_frames - first);
  const std::size_t n_channels = s.config.channels.size();
  std::vector<double> interleaved(n_channels > 1 ? static_cast<std::size_t>(n) * n_channels : 0);
  for (std::size_t c = 0; c < n_channels; ++c) {
    std::vector<double> sound = s.config.channels[c].gain == 0.0 ? std::vector<double>(static_cast<std::size_t>(n), 0.0)
                                                                 : s.sound_in_room(c, first, n);
    s.background->add(c, first, sound);
    for (double& sample : sound) sample = std::clamp(sample, -1.0, 1.0);
    if (n_channels == 1) return sound;
    for (std::size_t k = 0; k < sound.size(); ++k) interleaved[k * n_channels + c] = sound[k];
  }
  return interleaved;
}

std::vector<double> SyntheticRecording::samples() const {
  std::vector<double> all;
  for (std::int64_t k = 0; k < n_segments(); ++k) {
    const std::vector<double> part = segment(k);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

}  // namespace bouncelab
