// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"

namespace bouncelab::synthesis {
namespace {

std::size_t first_live_channel(const std::vector<Channel>& channels) {
  const auto alive =
      std::find_if(channels.begin(), channels.end(), [](const Channel& channel) { return channel.gain != 0.0; });
  return static_cast<std::size_t>(alive - channels.begin());
}

}  // namespace

StrikeSound::StrikeSound(const SynthesisConfig& config, std::shared_ptr<const Instrument> instrument)
    : config_(config),
      instrument_(std::move(instrument)),
      measured_channel_(first_live_channel(config.channels)),
      whitening_(instrument_->bank(), FlickerFilter(config.noise_corner_hz, config.rate_hz)) {}

/// A few at a time: those of the drops that sound and of those before, in each channel. All are the same whoever asks
/// first.
std::shared_ptr<const PointResponse> StrikeSound::response(std::size_t channel, const Strike& strike) const {
  const Place place{channel, strike.x_m, strike.y_m};
  const std::lock_guard lock(mutex_);
  for (const auto& [at, response] : responses_)
    if (at == place) return response;
  if (responses_.size() == 2 * config_.channels.size() * static_cast<std::size_t>(config_.together))
    responses_.erase(responses_.begin());
  responses_.emplace_back(place,
                          std::make_shared<const PointResponse>(instrument_->bank(), amplitudes(channel, strike)));
  return responses_.back().second;
}

StrikeSound::Wave StrikeSound::wave_at(std::size_t channel, const Strike& strike) const {
  const Disturbances& d = config_.disturbances;
  const bool is_as_before = strike.shares_point && d.timbre_wander == 0.0 && d.phase_wander_rad == 0.0 &&
                            strike.duration_s * config_.rate_hz <= PointResponse::kLongestContact_samples;
  if (is_as_before)
    return [at = response(channel, strike)](const Contact& contact, bool with_slopes) {
      return at->wave(contact, with_slopes);
    };
  return [this, at = amplitudes(channel, strike)](const Contact& contact, bool with_slopes) {
    return instrument_->bank().wave(contact, at, with_slopes);
  };
}

PoleValues StrikeSound::amplitudes(std::size_t channel, const Strike& strike) const {
  std::vector<double> shapes = instrument_->shapes_under_ball(strike.x_m, strike.y_m);
  const Disturbances& d = config_.disturbances;
  Random random(config_.seed, RandomStream::plate, (1ull << 63) | static_cast<std::uint64_t>(strike.impact_index + 1));
  if (d.timbre_wander > 0.0)
    for (double& shape : shapes) shape *= exp(d.timbre_wander * random.normal());
  PoleValues result = instrument_->amplitudes(channel, shapes);
  if (d.phase_wander_rad > 0.0)
    for (std::size_t k = 0; k < shapes.size(); ++k)
      result.set(k, result[k] * polar(1.0, d.phase_wander_rad * random.normal()));
  return result;
}

Contact StrikeSound::contact(std::size_t channel, const Strike& strike) const {
  const double arrival_s = strike.t_s + instrument_->travel_time_s(channel, strike.x_m, strike.y_m);
  return {arrival_s * config_.rate_hz, strike.duration_s * config_.rate_hz, strike.impulse_ns};
}

double StrikeSound::largest_delay_s() const {
  const RectangularPlate& plate = config_.ground.carrier;
  double travel_s = 0.0, echo_s = 0.0;
  for (std::size_t c = 0; c < config_.channels.size(); ++c)
    travel_s = std::max(travel_s, instrument_->travel_time_s(c, -0.5 * plate.length_x_m, -0.5 * plate.length_y_m) +
                                      instrument_->travel_time_s(c, 0.5 * plate.length_x_m, 0.5 * plate.length_y_m));
  for (const Echo& echo : config_.sensor.echoes) echo_s = std::max(echo_s, echo.delay_s);
  constexpr double kContact_s = 1e-3;
  return travel_s + echo_s + kContact_s;
}

std::vector<double> StrikeSound::peaks(std::span<const Strike> strikes) const {
  std::vector<double> result(strikes.size());
  parallel_for(strikes.size(), config_.n_threads, [&](std::size_t k) {
    const ContactWave wave = wave_at(measured_channel_, strikes[k])(contact(measured_channel_, strikes[k]), false);
    result[k] = instrument_->meter().peak(wave);
  });
  return result;
}

TrueImpact StrikeSound::true_impact(const Strike& strike, const ContactWave& sound) const {
  WaveMeasure wave = instrument_->meter().measure(sound, whitening_);
  if (has_room()) wave.slope_energy = slope_energy_in_room(strike, sound);
  TrueImpact row;
  row.drop = strike.drop;
  row.impact = strike.impact;
  row.t_s = strike.t_s;
  row.sigma_t_s = 1.0 / (whitening_.noise.rms() * config_.rate_hz * std::sqrt(wave.slope_energy));
  row.amplitude = wave.peak;
  row.contact_time_s = strike.duration_s;
  row.travel_time_s = instrument_->travel_time_s(measured_channel_, strike.x_m, strike.y_m);
  row.x_m = strike.x_m;
  row.y_m = strike.y_m;
  row.v_mps = strike.v_mps;
  return row;
}

std::vector<TrueImpact> StrikeSound::truth(std::span<const Strike> strikes, std::vector<ContactWave>* waves) const {
  std::vector<std::size_t> hits;
  for (std::size_t k = 0; k < strikes.size(); ++k)
    if (strikes[k].impact_index >= 0) hits.push_back(k);
  if (waves) waves->assign(strikes.size(), ContactWave());
  std::vector<TrueImpact> rows(hits.size());
  parallel_for(hits.size(), config_.n_threads, [&](std::size_t k) {
    const Strike& strike = strikes[hits[k]];
    ContactWave wave = wave_at(measured_channel_, strike)(contact(measured_channel_, strike), true);
    rows[k] = true_impact(strike, wave);
    wave.slopes = {};
    if (waves) (*waves)[hits[k]] = std::move(wave);
  });
  return rows;
}

void scale_to(const Levels& levels, std::vector<TrueImpact>& truth) {
  for (TrueImpact& row : truth) {
    row.amplitude *= levels.gain;
    row.sigma_t_s *= levels.noise_rms / levels.gain;
    row.snr_db = 20.0 * std::log10(row.amplitude / levels.noise_rms);
    if (row.amplitude > 1.0) row.flags.add(Flag::clipped);
  }
}

Levels levels_for(const SynthesisConfig& config, double weakest_peak, double strongest_peak) {
  if (!(weakest_peak > 0.0))
    throw InvalidArgument(
        "an impact makes no sound at the sensor: it strikes, or is heard, where no mode moves; move the "
        "sensor or let modes of higher frequencies sound");
  Levels levels;
  levels.gain = config.peak / strongest_peak;
  levels.weakest_peak = weakest_peak * levels.gain;
  levels.noise_rms = levels.weakest_peak * pow(10.0, -config.snr_db / 20.0);
  return levels;
}

}  // namespace bouncelab::synthesis
