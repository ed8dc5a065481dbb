// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::synthesis {
namespace {

/// A resonator is set to zero when it is below the last of 32 bits, or 80 dB below the noise.
constexpr double kSilence = 1e-11, kSilenceInNoise = 1e-4;
constexpr std::int64_t kBlock = ResonatorBank::kBlock;

/// Frames that are made, from ringing to rounding, while they are in the first-level cache.
constexpr std::size_t kPiece = 2048;

/// Of a piece: noise, rounded and stored, so few that the processor stores them while it computes the next.
constexpr std::size_t kPart = 256;

/// 2.5 s: long against the plate's memory, of which each segment computes the beginning anew.
std::int64_t frames_of_a_segment(int rate_hz) {
  return std::max<std::int64_t>(1 << 16, std::int64_t{rate_hz} * 5 / 2 / kBlock * kBlock);
}

ContactWave scaled(ContactWave wave, double gain) {
  for (double& y : wave.samples) y *= gain;
  for (std::size_t p = 0; p < wave.ringing.size(); ++p) wave.ringing.set(p, gain * wave.ringing[p]);
  return wave;
}

/// The sound of contacts in one channel from a frame on, piece by piece: their waves until they ring freely, and from
/// there on the ringing of all in one state.
class StrikeRinging {
 public:
  /// @param first  a multiple of kBlock
  /// @param bank   must outlive this
  StrikeRinging(const ResonatorBank& bank, double silence, std::int64_t first)
      : bank_(bank), silence_(silence), at_(first), state_(bank.size()) {}

  /// Before the first piece, in the order of time.
  void add(ContactWave wave) {
    if (wave.end() > at_) return waves_.push_back(std::move(wave));
    bank_.advance(wave.ringing, at_ - wave.end());
    join(wave.ringing);
  }

  /// Adds the sound of the next frames to `out`, whose length is a multiple of kBlock.
  template <class T>
  void add_next(std::span<T> out) {
    const std::int64_t first = at_, end = first + static_cast<std::int64_t>(out.size());
    for (const ContactWave& wave : waves_)
      for (std::int64_t k = std::max(wave.first, first); k < std::min(wave.end(), end); ++k)
        out[static_cast<std::size_t>(k - first)] +=
            static_cast<T>(wave.samples[static_cast<std::size_t>(k - wave.first)]);
    while (!out.empty()) {
      // waves of contacts that follow one another closely need not end in their order
      std::int64_t until = end;
      for (const ContactWave& wave : waves_) {
        if (wave.end() == at_) join(wave.ringing);
        if (wave.end() > at_) until = std::min(until, wave.end());
      }
      std::erase_if(waves_, [this](const ContactWave& wave) { return wave.end() <= at_; });
      const auto n = static_cast<std::size_t>(until - at_);
      bank_.ring(state_, silence_, out.first(n));
      out = out.subspan(n);
      at_ = until;
    }
  }

 private:
  void join(const PoleValues& ringing) {
    for (std::size_t p = 0; p < state_.size(); ++p) state_.set(p, state_[p] + ringing[p]);
  }

  const ResonatorBank& bank_;
  double silence_;
  std::int64_t at_;  // frame of the next piece
  PoleValues state_;
  std::vector<ContactWave> waves_;  // that have not joined the ringing
};

/// To full scale. Inlined with a step of 1 it is a loop for the compiler to vectorise.
template <class T>
[[gnu::always_inline]] inline void clip(std::span<const T> samples, std::size_t step, double* out) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto y = static_cast<double>(samples[k]);
    const double at_least = y < -1.0 ? -1.0 : y;
    out[k * step] = at_least > 1.0 ? 1.0 : at_least;
  }
}

/// dy per sample of a wave, as a wave.
ContactWave slope_of(ContactWave wave, const ResonatorBank& bank) {
  wave.samples = std::move(wave.slopes);
  for (std::size_t p = 0; p < bank.size(); ++p)
    wave.ringing.set(p, wave.ringing[p] * bank.poles_per_s()[p] / bank.rate_hz());
  return wave;
}

}  // namespace

double StrikeSound::slope_energy_in_room(const Strike& strike, const ContactWave& direct) const {
  constexpr double kLeast = 1e-5;  // of the largest slope: of the energy its square counts
  const ResonatorBank& bank = instrument_->bank();
  const ReverberationTail& tail = instrument_->tail();
  double largest = 0.0;
  for (const double slope : direct.slopes) largest = std::max(largest, std::abs(slope));
  const std::int64_t n_blocks = (direct.end() - direct.first) / kBlock + 1;  // its end is the end of one
  StrikeRinging slopes(bank, kLeast * largest, direct.end() - n_blocks * kBlock);
  // until ringing (that falls by 220 dB in its memory) and tail (180 dB) are 30 dB down: a thousandth of their energy
  const std::int64_t n_frames = direct.end() - direct.first + (bank.memory_frames() + tail.memory_frames()) / 6 +
                                static_cast<std::int64_t>(largest_delay_s() * bank.rate_hz());
  const Wave wave = wave_at(measured_channel_, strike);
  slopes.add(slope_of(direct, bank));
  for (const Echo& echo : config_.sensor.echoes) {
    Contact late = contact(measured_channel_, strike);
    late.arrival_samples += echo.delay_s * config_.rate_hz;
    late.impulse *= echo.gain;
    slopes.add(slope_of(wave(late, true), bank));
  }
  std::vector<double> all(static_cast<std::size_t>((n_frames / kBlock + 2) * kBlock), 0.0);
  slopes.add_next(std::span(all));
  tail.add_to(all);
  whitening_.noise.whiten(all);
  double energy = 0.0;
  for (const double slope : all) energy += slope * slope;
  return energy;
}

Renderer::Renderer(const SynthesisConfig& config, const StrikeSound& sound, const Schedule& schedule,
                   const Levels& levels, const std::vector<ContactWave>& known)
    : config_(config),
      sound_(sound),
      schedule_(schedule),
      levels_(levels),
      known_(known),
      background_(config, schedule, sound.instrument().bank().filter(), levels),
      segment_frames_(frames_of_a_segment(config.rate_hz)),
      reach_back_s_(static_cast<double>(sound.instrument().bank().memory_frames() +
                                        sound.instrument().tail().memory_frames() + kBlock) /
                        config.rate_hz +
                    sound.largest_delay_s()),
      reach_ahead_s_((ConverterFilter::kHalfWidth_samples + 4.0) / config.rate_hz),
      silence_(std::max(kSilence, kSilenceInNoise * levels.noise_rms)) {}

/// Frames first ... first + n - 1 of one channel.
class PartsOfChannel {
 public:
  PartsOfChannel(const Renderer& renderer, std::size_t channel, std::int64_t first, std::int64_t n)
      : r_(renderer), channel_(channel), first_(first), n_(n) {}

  /// Clipped to full scale, every `step`-th number of out.
  void write(double* out, std::size_t step) const {
    // the noise, of which silence_ is 80 dB below, is 40 dB above what single precision rounds off amplitudes of 1
    constexpr double kSingleFrom = 1e-9;
    if (r_.silence_ >= kSingleFrom)
      write_by<float>(out, step);
    else
      write_by<double>(out, step);
  }

 private:
  /// The strike and its echoes, those that begin before frame `end`.
  void add_contacts(std::size_t strike, std::int64_t end, StrikeRinging& ringing) const {
    const Strike& at = r_.schedule_.strikes[strike];
    const bool is_known = channel_ == r_.sound_.measured_channel() && !r_.known_[strike].samples.empty();
    const auto begins = [end](const Contact& contact) {
      return contact.arrival_samples - ConverterFilter::kHalfWidth_samples < static_cast<double>(end);
    };
    Contact direct = r_.sound_.contact(channel_, at);
    direct.impulse *= r_.levels_.gain;
    const std::vector<Echo>& echoes = r_.config_.sensor.echoes;
    const StrikeSound::Wave wave = is_known && echoes.empty() ? StrikeSound::Wave() : r_.sound_.wave_at(channel_, at);
    if (begins(direct)) ringing.add(is_known ? scaled(r_.known_[strike], r_.levels_.gain) : wave(direct, false));
    for (const Echo& echo : echoes) {
      Contact late = direct;
      late.arrival_samples += echo.delay_s * r_.config_.rate_hz;
      late.impulse *= echo.gain;
      if (begins(late)) ringing.add(wave(late, false));
    }
  }

  /// From so many frames before the first one on.
  StrikeRinging ringing(std::int64_t run_in) const {
    const ResonatorBank& bank = r_.sound_.instrument().bank();
    const double rate_hz = r_.config_.rate_hz;
    const std::int64_t first = first_ - run_in, end = first_ + n_;
    StrikeRinging result(bank, r_.silence_, first);
    const double earliest_s = static_cast<double>(first - bank.memory_frames()) / rate_hz - r_.sound_.largest_delay_s();
    const double latest_s = static_cast<double>(end) / rate_hz + r_.reach_ahead_s_;
    const std::vector<Strike>& strikes = r_.schedule_.strikes;
    auto strike = std::lower_bound(strikes.begin(), strikes.end(), earliest_s,
                                   [](const Strike& s, double t_s) { return s.t_s < t_s; });
    for (; strike != strikes.end() && strike->t_s < latest_s; ++strike)
      add_contacts(static_cast<std::size_t>(strike - strikes.begin()), end, result);
    return result;
  }

  /// All strikes' sound with the reverberation tail, begun so early that its start has decayed.
  template <class T>
  std::vector<double> reverberant_sound() const {
    const ReverberationTail& tail = r_.sound_.instrument().tail();
    const std::int64_t run_in = (tail.memory_frames() + kBlock - 1) / kBlock * kBlock;
    std::vector<T> strikes(static_cast<std::size_t>((run_in + n_ + kBlock - 1) / kBlock * kBlock), T{});
    ringing(run_in).add_next(std::span<T>(strikes));
    std::vector<double> sound(strikes.begin(), strikes.end());
    tail.add_to(sound);
    return {sound.begin() + run_in, sound.begin() + run_in + n_};
  }

  template <class T>
  void write_by(double* out, std::size_t step) const {
    const Background& background = r_.background_;
    const auto n = static_cast<std::size_t>(n_);
    const bool is_dead = r_.config_.channels[channel_].gain == 0.0;
    const bool is_reverberant = r_.sound_.instrument().tail().is_audible() && !is_dead;
    std::vector<double> whole;  // what cannot be computed in pieces
    if (is_reverberant) whole = reverberant_sound<T>();
    if (!background.is_white()) {
      whole.resize(n, 0.0);
      background.add(channel_, first_, whole);
    }
    std::optional<StrikeRinging> strikes;
    if (!is_dead && !is_reverberant) strikes.emplace(ringing(0));
    std::array<T, kPiece> piece;
    for (std::size_t at = 0; at < n; at += kPiece) {
      piece.fill(T{});
      if (strikes) strikes->add_next(std::span<T>(piece));
      const std::size_t n_wanted = std::min(kPiece, n - at);
      for (std::size_t begin = 0; begin < n_wanted; begin += kPart) {
        const std::span<T> part = std::span(piece).subspan(begin, std::min(kPart, n_wanted - begin));
        const std::int64_t frame = first_ + static_cast<std::int64_t>(at + begin);
        if (!whole.empty())
          for (std::size_t k = 0; k < part.size(); ++k) part[k] += static_cast<T>(whole[at + begin + k]);
        if (background.is_white()) background.add_white(channel_, frame, part);
        if (!r_.schedule_.pushes.empty()) apply_gain(r_.schedule_.pushes, frame, r_.config_.rate_hz, part);
        if (step == 1)
          clip<T>(part, 1, out + at + begin);
        else
          clip<T>(part, step, out + (at + begin) * step);
      }
    }
  }

  const Renderer& r_;
  std::size_t channel_;
  std::int64_t first_, n_;
};

std::vector<double> Renderer::frames(std::int64_t first, std::int64_t n) const {
  const std::size_t n_channels = config_.channels.size();
  std::vector<double> interleaved(static_cast<std::size_t>(n) * n_channels);
  for (std::size_t c = 0; c < n_channels; ++c)
    PartsOfChannel(*this, c, first, n).write(interleaved.data() + c, n_channels);
  return interleaved;
}

namespace {

/// NaN is in no range.
void require_range(const std::string& name, double value, double lo, double hi) {
  if (value >= lo && value <= hi) return;
  throw InvalidArgument(name + " is " + short_number(value) + "; it must be from " + short_number(lo) + " to " +
                        short_number(hi));
}

void validate(const Disturbances& d) {
  constexpr double kMuch = 1e3;
  require_range("hum_level", d.hum_level, 0.0, kMuch);
  require_range("hum_hz", d.hum_hz, 1.0, 1000.0);
  require_range("drift_level", d.drift_level, 0.0, kMuch);
  require_range("clicks_per_s", d.clicks_per_s, 0.0, kMuch);
  require_range("knocks_per_s", d.knocks_per_s, 0.0, kMuch);
  require_range("double_hit_fraction", d.double_hit_fraction, 0.0, 1.0);
  require_range("timbre_wander", d.timbre_wander, 0.0, 3.0);
  require_range("phase_wander_rad", d.phase_wander_rad, 0.0, 10.0);
  require_range("speech_per_s", d.speech_per_s, 0.0, 20.0);
}

void validate(const std::vector<Channel>& channels, const SynthesisConfig& config) {
  require_range("number of channels", static_cast<double>(channels.size()), 1.0, 8.0);
  const RectangularPlate& plate = config.ground.carrier;
  for (const Channel& channel : channels) {
    if (config.sensor.kind == SensorKind::piezo) {
      require_range("sensor x_m", channel.x_m, -0.5 * plate.length_x_m, 0.5 * plate.length_x_m);
      require_range("sensor y_m", channel.y_m, -0.5 * plate.length_y_m, 0.5 * plate.length_y_m);
    } else {
      require_range("microphone x_m", channel.x_m, -10.0, 10.0);
      require_range("microphone y_m", channel.y_m, -10.0, 10.0);
      require_range("microphone z_m", channel.z_m, 0.01, 10.0);
    }
    require_range("channel gain", channel.gain, -1e3, 1e3);
  }
  if (std::all_of(channels.begin(), channels.end(), [](const Channel& c) { return c.gain == 0.0; }))
    throw InvalidArgument("every channel is dead; at least one gain must not be 0");
}

}  // namespace

void validate(const SynthesisConfig& config) {
  require_range("rate_hz", config.rate_hz, 8000, 2000000);
  require_range("snr_db", config.snr_db, -40.0, 200.0);
  require_range("noise_corner_hz", config.noise_corner_hz, 0.0, 0.25 * config.rate_hz);
  require_range("peak", config.peak, 1e-6, 1e3);
  require_range("lead_in_s", config.lead_in_s, 0.01, 3600.0);
  require_range("pause_s", config.pause_s, 0.05, 3600.0);
  require_range("together", config.together, 1, 8);
  require_range("start_spread_m", config.start_spread_m, 0.0, 1.0);
  require_range("gain_control_db", config.gain_control_db, 0.0, 40.0);
  require_range("max_mode_hz", config.max_mode_hz, 100.0, 200e3);
  require_range("ball radius_m", config.ball.radius_m, 1e-5, 1.0);
  const Material& plate = contact_material(config.ground);
  if (!contact_duration(config.ball, plate))
    throw InvalidArgument("how long " + to_text(config.ball) + " touches " + plate_text(plate) +
                          " is not known: Hertz's theory does not hold for it; give a contact time that was measured, "
                          "--ball " +
                          to_text(config.ball) + ",contact-time=0.8ms");
  const RectangularPlate& carrier = config.ground.carrier;
  for (const auto& [name, size_m] : {std::pair{"length_x_m", carrier.length_x_m},
                                     {"length_y_m", carrier.length_y_m},
                                     {"thickness_m", carrier.thickness_m}})
    require_range(std::string("carrier ") + name, size_m, 1e-5, 1e3);
  validate(config.channels, config);
  validate(config.disturbances);
  if (config.levels) {
    require_range("levels gain", config.levels->gain, 1e-300, 1e300);
    require_range("levels noise_rms", config.levels->noise_rms, 1e-30, 1e3);
    require_range("levels weakest_peak", config.levels->weakest_peak, 1e-30, 1e3);
  }
}

void validate(const Impacts& impacts, const SynthesisConfig& config) {
  if (impacts.rows.empty()) throw InvalidArgument("there are no impacts to synthesize; simulate some first");
  if (!impacts.states.empty() && impacts.states.size() != impacts.rows.size())
    throw InvalidArgument(std::to_string(impacts.states.size()) + " states for " + std::to_string(impacts.rows.size()) +
                          " impacts; there must be one for each, or none");
  for (std::size_t k = 0; k < impacts.rows.size(); ++k) {
    const Impact& impact = impacts.rows[k];
    const std::string place =
        "drop " + std::to_string(impact.drop) + ", impact " + std::to_string(impact.impact) + ": ";
    const bool goes_on = k > 0 && impacts.rows[k - 1].drop == impact.drop;
    if (!(impact.t_s >= 0.0) || !std::isfinite(impact.t_s))
      throw InvalidArgument(place + "t_s is " + std::to_string(impact.t_s) + "; it must be finite and not negative");
    if (k > 0 && impact.drop < impacts.rows[k - 1].drop)
      throw InvalidArgument(place + "follows drop " + std::to_string(impacts.rows[k - 1].drop) +
                            "; sort by drop and time");
    if (goes_on && impact.t_s <= impacts.rows[k - 1].t_s)
      throw InvalidArgument(place + "t_s " + std::to_string(impact.t_s) + " does not come after " +
                            std::to_string(impacts.rows[k - 1].t_s) + "; sort by drop and time");
    constexpr double kLongestDrop_s = 1e6;  // eleven days of one ball; the paper's whole experiment took 7 hours
    if (std::abs(impact.t_s) > kLongestDrop_s)
      throw InvalidArgument(place + "t_s is " + std::to_string(impact.t_s) + "; no drop lasts longer than 1e6 s");
    if (!(impact.v_mps > 0.0) || !std::isfinite(impact.v_mps) || !std::isfinite(impact.v_after_mps))
      throw InvalidArgument(place + "v_mps is " + std::to_string(impact.v_mps) + "; it must be positive and finite");
    if (impacts.states.empty() || !config.simulated_positions) continue;
    const auto& position = impacts.states[k].position_m;
    if (!contains(config.ground, position[0], position[1]))
      throw OffThePlate(
          place + "x = " + std::to_string(position[0]) + " m, y = " + std::to_string(position[1]) +
          " m is off the plate; let the simulation end the drop at the edge of the plate, or draw the positions");
  }
}

void check_contact(double duration_s, const SynthesisConfig& config) {
  if (duration_s * config.rate_hz <= kMaxContact_samples) return;
  throw InvalidArgument("a contact of " + std::to_string(duration_s * 1e6) + " us is " +
                        std::to_string(duration_s * config.rate_hz) + " samples long, more than " +
                        std::to_string(kMaxContact_samples) + "; lower the rate");
}

}  // namespace bouncelab::synthesis
