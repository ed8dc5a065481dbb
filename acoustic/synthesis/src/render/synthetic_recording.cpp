// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/synthetic_recording.hpp"

#include <algorithm>
#include <cmath>

#include "bouncelab/core/error.hpp"
#include "bouncelab/synthesis/synthesize.hpp"
#include "render/renderer.hpp"

namespace bouncelab::synthesis {

std::shared_ptr<const Instrument> make_instrument(const SynthesisConfig& config) {
  validate(config);
  return std::make_shared<const Instrument>(config.ground, config.sensor, config.channels, config.rate_hz,
                                            std::min(config.max_mode_hz, 0.5 * config.rate_hz));
}

struct SyntheticRecording::State {
  State(const Impacts& impacts, const SynthesisConfig& config_, std::shared_ptr<const Instrument> instrument)
      : config(with_levels(impacts, config_, instrument)),
        sound(config, std::move(instrument)),
        schedule(schedule_of(impacts, config)),
        truth(sound.truth(schedule.strikes, &waves)),
        levels(config.levels ? *config.levels : levels_of(truth, config)),
        renderer(config, sound, schedule, levels, waves),
        n_frames(static_cast<std::int64_t>(std::ceil(schedule.duration_s * config.rate_hz))) {
    scale_to(levels, truth);
    add_pushes(config, truth, schedule);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Where the ball makes no sound, the levels are still those of its impacts.
  static SynthesisConfig with_levels(const Impacts& impacts, SynthesisConfig config,
                                     const std::shared_ptr<const Instrument>& instrument) {
    if (!config.without_ball || config.levels) return config;
    config.without_ball = false;
    config.levels = State(impacts, config, instrument).levels;
    config.without_ball = true;
    return config;
  }

  static Schedule schedule_of(const Impacts& impacts, const SynthesisConfig& config) {
    double weakest_ns = impulse_ns(config, impacts.rows.front());
    for (const Impact& impact : impacts.rows) weakest_ns = std::min(weakest_ns, impulse_ns(config, impact));
    Schedule schedule;
    Scheduler scheduler(config, weakest_ns);
    const DropSource groups = in_groups(drops_of(impacts), config.together);
    Impacts group;
    for (std::int64_t k = 0; groups(k, group); ++k) scheduler.add_group(group, schedule);
    for (const Strike& strike : schedule.strikes) check_contact(strike.duration_s, config);
    return schedule;
  }

  static Levels levels_of(const std::vector<TrueImpact>& unit_truth, const SynthesisConfig& config) {
    const auto [weakest, strongest] = std::minmax_element(
        unit_truth.begin(), unit_truth.end(), [](const auto& a, const auto& b) { return a.amplitude < b.amplitude; });
    return levels_for(config, weakest->amplitude, strongest->amplitude);
  }

  SynthesisConfig config;
  StrikeSound sound;
  Schedule schedule;
  std::vector<ContactWave> waves;  // from which the truth is read, and the samples are made
  std::vector<TrueImpact> truth;
  Levels levels;
  Renderer renderer;
  std::int64_t n_frames;
};

namespace {

const Impacts& checked(const Impacts& impacts, const SynthesisConfig& config) {
  validate(config);
  validate(impacts, config);
  return impacts;
}

}  // namespace

SyntheticRecording::SyntheticRecording(const Impacts& impacts, const SynthesisConfig& config,
                                       std::shared_ptr<const Instrument> instrument)
    : state_(std::make_shared<const State>(checked(impacts, config), config,
                                           instrument ? std::move(instrument) : make_instrument(config))) {}

std::int64_t SyntheticRecording::n_frames() const { return state_->n_frames; }
const std::vector<TrueImpact>& SyntheticRecording::truth() const { return state_->truth; }
const std::vector<OtherSound>& SyntheticRecording::others() const { return state_->schedule.others; }
const Levels& SyntheticRecording::levels() const { return state_->levels; }
std::int64_t SyntheticRecording::segment_frames() const { return state_->renderer.segment_frames(); }

std::int64_t SyntheticRecording::n_segments() const { return (n_frames() + segment_frames() - 1) / segment_frames(); }

std::vector<double> SyntheticRecording::segment(std::int64_t index) const {
  const std::int64_t first = index * segment_frames();
  return state_->renderer.frames(first, std::min(segment_frames(), n_frames() - first));
}

std::vector<double> SyntheticRecording::samples() const {
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(n_frames()) * state_->config.channels.size());
  for (std::int64_t k = 0; k < n_segments(); ++k) {
    const std::vector<double> part = segment(k);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

std::vector<float> SyntheticRecording::samples_as_read_back() const {
  std::vector<float> all;
  all.reserve(static_cast<std::size_t>(n_frames()) * state_->config.channels.size());
  for (std::int64_t k = 0; k < n_segments(); ++k) {
    const std::vector<float> part = audio::as_read_back(segment(k), state_->config.encoding);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

const char* to_string(OtherSoundKind kind) {
  static constexpr const char* kNames[]{"click", "knock", "speech"};
  return kNames[static_cast<std::size_t>(kind)];
}
Onsets onsets_of_truth(const std::vector<TrueImpact>& truth, const std::string& recording) {
  Onsets onsets;
  for (const TrueImpact& impact : truth)
    onsets.push_back({recording, impact.drop, impact.impact, impact.t_s, {}, impact.amplitude, impact.snr_db, {}});
  return onsets;
}

const RowColumns<TrueImpact>& columns_of(const TrueImpact*) {
  using T = TrueImpact;
  static const RowColumns<T> all{
      column("drop", &T::drop, "Number of the drop"),
      column("impact", &T::impact, "Number of the impact within its drop"),
      column("t_s", &T::t_s, "Start of contact at the plate, exact"),
      column("sigma_t_s", &T::sigma_t_s,
             "Cramér-Rao bound: the least standard error of any unbiased detector that "
             "knows the waveform, with echoes and tail of a microphone's room; no error of `t_s` here, "
             "which is exact"),
      column("amplitude", &T::amplitude,
             "Peak of the impact's sound, full scale = 1, before clipping and gain control"),
      column("snr_db", &T::snr_db, "`amplitude` over the noise rms [dB]"),
      column("flags", &T::flags, "`clipped` where the sound reaches full scale"),
      column("contact_time_s", &T::contact_time_s, "Hertzian contact time"),
      column("travel_time_s", &T::travel_time_s,
             "The sound begins at `t_s + travel_time_s` at the (first live) sensor"),
      column("x_m", &T::x_m, "Point of contact on the plate, along x"),
      column("y_m", &T::y_m, "Likewise, along y"),
      column("v_mps", &T::v_mps, "Normal impact speed")};
  return all;
}

Table truth_table(const std::vector<TrueImpact>& truth, const std::string& recording) {
  Table table{{{"recording", std::vector<std::string>(truth.size(), recording_cell(recording))}}};
  for (Column& c : table_of<TrueImpact>(columns_of(truth.data()), truth).columns) table.columns.push_back(std::move(c));
  return table;
}

Table others_table(const std::vector<OtherSound>& others) {
  std::vector<std::string> kind;
  std::vector<double> t_s;
  for (const OtherSound& sound : others) {
    kind.push_back(to_string(sound.kind));
    t_s.push_back(sound.t_s);
  }
  return {{{"kind", std::move(kind)}, {"t_s", std::move(t_s)}}};
}

namespace {

void add_dead_channel(SynthesisConfig& c) {
  Channel dead = c.channels.front();
  dead.gain = 0.0;
  c.channels.insert(c.channels.begin(), dead);
}

constexpr HardCase kHardCases[]{
    {"noisy", "weakest impact only 10 dB above white and 1/f noise",
     [](SynthesisConfig& c) {
       c.snr_db = 10.0;
       c.noise_corner_hz = 500.0;
     }},
    {"hum", "mains hum louder than the weakest impact, drift of the zero line",
     [](SynthesisConfig& c) {
       c.disturbances.hum_level = 1.5;
       c.disturbances.drift_level = 2.0;
     }},
    {"clicks", "electric clicks, one a second", [](SynthesisConfig& c) { c.disturbances.clicks_per_s = 1.0; }},
    {"knocks", "a second object strikes the plate every two seconds",
     [](SynthesisConfig& c) { c.disturbances.knocks_per_s = 0.5; }},
    {"double-hits", "half of the impacts are followed by a knock within 12 ms",
     [](SynthesisConfig& c) { c.disturbances.double_hit_fraction = 0.5; }},
    {"clipped", "strong impacts three times beyond full scale", [](SynthesisConfig& c) { c.peak = 3.0; }},
    {"wander", "amplitudes and phases of the modes change from impact to impact",
     [](SynthesisConfig& c) {
       c.disturbances.timbre_wander = 0.4;
       c.disturbances.phase_wander_rad = 0.5;
     }},
    {"dead-channel", "two channels, the first one holds noise only", add_dead_channel},
    {"ringing", "a plate that rings three times as long",
     [](SynthesisConfig& c) {
       for (Damping* damping : {&c.ground.carrier_damping, &c.ground.disk_damping}) {
         damping->loss_factor /= 3.0;
         damping->support_per_s /= 3.0;
       }
     }},
    {"microphone", "by air, 30 cm above the plate, with echoes",
     [](SynthesisConfig& c) {
       c.sensor = microphone();
       for (Channel& channel : c.channels) channel.z_m = 0.3;
     }},
    {"rough", "noise at 20 dB, hum, clicks, knocks, some double hits, wander",
     [](SynthesisConfig& c) {
       c.snr_db = 20.0;
       c.noise_corner_hz = 300.0;
       c.disturbances.hum_level = 0.5;
       c.disturbances.drift_level = 0.5;
       c.disturbances.clicks_per_s = 0.3;
       c.disturbances.knocks_per_s = 0.1;
       c.disturbances.double_hit_fraction = 0.1;
       c.disturbances.timbre_wander = 0.2;
     }},
};

}  // namespace

Description members_of(const Disturbances*) {
  using D = Disturbances;
  static constexpr Member options[]{
      member<&D::hum_level>("hum", "Mains hum with harmonics").within(0.0, 1e6),
      member<&D::hum_hz>("hum_hz", "Mains frequency [Hz]").within(1.0, 1000.0),
      member<&D::drift_level>("drift", "Slow drift of the zero line").within(0.0, 1e6),
      member<&D::clicks_per_s>("clicks", "Electric clicks [1/s]").within(0.0, 1e4),
      member<&D::knocks_per_s>("knocks", "Knocks of a second object [1/s]").within(0.0, 1e4),
      member<&D::double_hit_fraction>("double_hits", "Share of impacts followed by a knock within 12 ms")
          .within(0.0, 1.0),
      member<&D::timbre_wander>("timbre_wander", "Standard deviation of ln(mode amplitude) between impacts")
          .within(0.0, 3.0),
      member<&D::phase_wander_rad>("phase_wander", "Standard deviation of mode phases between impacts [rad]")
          .within(0.0, 10.0),
      member<&D::speech_per_s>("speech", "Voiced syllables, peaks at levels 0.5 to 5 [1/s]").within(0.0, 20.0)};
  return options;
}

std::span<const HardCase> hard_cases() { return kHardCases; }

SynthesisConfig with_hard_case(SynthesisConfig config, const std::string& name) {
  std::string names;
  for (const HardCase& known : kHardCases) {
    if (known.name == name) {
      known.apply(config);
      return config;
    }
    names += (names.empty() ? "" : ", ") + std::string(known.name);
  }
  throw InvalidArgument("hard case '" + name + "' is not known; the cases are " + names);
}

}  // namespace bouncelab::synthesis
