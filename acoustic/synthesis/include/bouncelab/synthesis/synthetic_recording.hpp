// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/synthesis/plate.hpp"

namespace bouncelab::synthesis {

enum class SensorKind { piezo, microphone };

/// A reflection off table or wall: the impact once more, later and weaker.
struct Echo {
  double delay_s = 0.0;  ///< after the direct sound, >= 0
  double gain = 0.0;     ///< of the direct sound
};

/// The diffuse sound of a room: after the direct sound a dense tail that falls by 60 dB in `decay_60db_s`.
struct Reverberation {
  double level_db = -200.0;   ///< energy of the tail of a short sound over that of the direct sound; -200: none
  double decay_60db_s = 0.3;  ///< 0.02 to 20
};

/// From the plate's motion to voltage. Both kinds respond to acceleration (a piezo disc by inertia, sound radiated by a
/// plate in far field), through AC coupling and a resonance:
///
///   H(s) = s^2  s / (s + w_h)  w_r^2 / (s^2 + w_r s / Q + w_r^2)
///
/// By default a bare piezo disc glued to the plate: 25 kHz, Q = 2, charge amplifier from 150 Hz. A microphone receives
/// each mode through Rayleigh's integral over the plate at the mode's frequency, and echoes.
struct Sensor {
  SensorKind kind = SensorKind::piezo;
  double highpass_hz = 150.0;    ///< > 0
  double resonance_hz = 25.0e3;  ///< > 0
  double quality = 2.0;          ///< > 0.5
  std::vector<Echo> echoes;      ///< of a microphone
  Reverberation reverberation;   ///< of a microphone's room
};

/// A small condenser microphone: 40 Hz to 20 kHz without a peak, three early echoes of table and
/// walls, a diffuse tail 15 dB down that lasts 0.25 s.
Sensor microphone();

/// One channel of the recording: where its sensor is. Piezos sit on the plate (z = 0), microphones above it.
struct Channel {
  double x_m = 0.115;
  double y_m = 0.065;
  double z_m = 0.0;
  double gain = 1.0;  ///< relative to the other channels; 0: dead, noise only
};

/// Sounds and interference of a laboratory beside the ball. All off by default. Levels are in units of the clean peak
/// of the weakest wanted impact, so that 1 is as loud as the weakest impact to be detected.
struct Disturbances {
  double hum_level = 0.0;     ///< amplitude of the mains' fundamental; harmonics 2 to 7 fall like 1/n
  double hum_hz = 50.0;       ///< > 0
  double drift_level = 0.0;   ///< slow wander of the zero line, periods 2 to 15 s
  double clicks_per_s = 0.0;  ///< electric clicks two samples long, levels 0.3 to 5, Poisson in time
  double knocks_per_s = 0.0;  ///< a second, softer object strikes the plate, levels about 0.5 to 4, Poisson in time
  double double_hit_fraction = 0.0;  ///< in [0, 1]: share of impacts followed by a knock after 1.5 to 12 ms
  double timbre_wander = 0.0;        ///< standard deviation of ln(mode amplitude) from impact to impact
  double phase_wander_rad = 0.0;     ///< standard deviation of the modes' phases from impact to impact
  double speech_per_s = 0.0;         ///< voiced syllables, peaks at levels 0.5 to 5, Poisson in time
};
Description members_of(const Disturbances*);

/// A simulated ball strikes where the ground is no more.
class OffThePlate : public InvalidArgument {
 public:
  using InvalidArgument::InvalidArgument;
};

/// Amplification and noise of a recording, full scale = 1. Computed from the impacts unless given.
struct Levels {
  double gain = 0.0;          ///< from the sensor's signal to full scale
  double noise_rms = 0.0;     ///< of the stationary noise
  double weakest_peak = 0.0;  ///< clean peak of the weakest wanted impact, the unit of Disturbances
};

struct SynthesisConfig {
  Ground ground = ground_of(kGlass);
  Sensor sensor;
  std::vector<Channel> channels{Channel{}};  ///< 1 to 8; amplitudes and bounds refer to the first one that is not dead
  Ball ball;
  int rate_hz = 96000;  ///< 8000 to 2,000,000
  audio::SampleEncoding encoding = audio::SampleEncoding::pcm24;
  double snr_db = 30.0;          ///< clean peak of the weakest wanted impact over noise rms, -40 to 200
  double noise_corner_hz = 0.0;  ///< below it the noise grows like 1/f (down to 5 Hz); 0: white
  double peak = 0.5;             ///< clean peak of the strongest impact, full scale = 1; above 1 it is clipped
  double lead_in_s = 0.5;        ///< before the first release
  double pause_s = 1.0;          ///< from the last impact of a group to the next release, and to the end
  int together = 1;              ///< 1 to 8 balls at once: so many drops in turn are one group, and pauses part groups
  bool simulated_positions = true;  ///< points of contact from the states, if there are any
  double start_spread_m = 0.02;     ///< otherwise each drop strikes at one point, uniform in |x|, |y| <= this
  double gain_control_db = 0.0;  ///< how far a phone's automatic gain is pushed down by the strongest impact, 0 to 40
  double max_mode_hz = 45.0e3;   ///< modes above are left out; plate theory ends about here
  Disturbances disturbances;
  bool without_ball = false;     ///< everything else sounds as it did, and there is no truth
  std::optional<Levels> levels;  ///< fixed, so that recordings made one by one belong together
  std::uint64_t seed = 1;
  int n_threads = 1;  ///< 0: all cores; the samples do not depend on it
};

/// The true values of one impact in the recording.
struct TrueImpact {
  std::int64_t drop = 0;
  std::int64_t impact = 0;
  double t_s = 0.0;        ///< begin of contact at the plate, from the first sample; what eq. 2 of the paper needs
  double sigma_t_s = 0.0;  ///< Cramer-Rao bound of t_s for the known wave, with echoes and tail, this impact alone;
                           ///< gain control, which scales sound and noise alike, leaves it as it is
  double amplitude = 0.0;  ///< clean peak of the direct sound before gain control, full scale = 1
  double snr_db = 0.0;     ///< amplitude over noise rms
  double contact_time_s = 0.0;  ///< of the ball on the ground, core/ball.hpp
  double travel_time_s = 0.0;   ///< the sound begins at t_s + travel_time_s, which is what a detector finds
  double x_m = 0.0, y_m = 0.0;  ///< point of contact
  double v_mps = 0.0;           ///< normal impact speed
  Flags flags;                  ///< clipped or none
};
/// All but the recording.
const RowColumns<TrueImpact>& columns_of(const TrueImpact*);

/// What makes a sound that is not an impact of the ball.
enum class OtherSoundKind { click, knock, speech };
/// The enumerator's name, as tables of other sounds have it.
const char* to_string(OtherSoundKind kind);

/// A sound that is not an impact of the ball: detecting it is a false alarm.
struct OtherSound {
  OtherSoundKind kind = OtherSoundKind::knock;
  double t_s = 0.0;  ///< from the first sample
};

class Instrument;
/// The part of a synthesis that does not depend on the impacts (modes of the plate, tables): for many recordings with
/// one configuration, made once. Depends on ground, sensor, channels, rate_hz and max_mode_hz only.
std::shared_ptr<const Instrument> make_instrument(const SynthesisConfig& config);

/// A recording as a function of time. Its samples are computed on request, segment by segment, in any order and on any
/// thread.
class SyntheticRecording {
 public:
  /// @param instrument  from make_instrument with the same configuration; made here where absent
  /// @throws InvalidArgument naming the value: a setting out of range, no impacts ...; OffThePlate naming the impact
  SyntheticRecording(const Impacts& impacts, const SynthesisConfig& config,
                     std::shared_ptr<const Instrument> instrument = nullptr);

  std::int64_t n_frames() const;
  const std::vector<TrueImpact>& truth() const;
  const std::vector<OtherSound>& others() const;
  const Levels& levels() const;

  /// The recording is rendered in segments of a few seconds; n_segments() of segment_frames() frames, the last shorter.
  std::int64_t n_segments() const;
  std::int64_t segment_frames() const;
  /// Samples of one segment, interleaved by channel, clipped to full scale, not yet rounded to the encoding.
  std::vector<double> segment(std::int64_t index) const;
  /// All samples: for short recordings.
  std::vector<double> samples() const;
  /// The same as they would be read back from a file of the configuration's encoding.
  std::vector<float> samples_as_read_back() const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

/// The configuration of one drop's own recording: gain and noise level from `levels`, another noise for each drop. A
/// function of (config, drop).
SynthesisConfig config_of_drop(const SynthesisConfig& config, const Levels& levels, std::int64_t drop);
/// NAME.0017.wav for out = NAME.wav and drop 17.
std::filesystem::path path_of_drop(const std::filesystem::path& out, std::int64_t drop);

/// The truth as onsets, for intervals without timing errors: t_s is the begin of contact at the plate, without standard
/// error and flags, because it is exact whatever the sound.
/// @param recording  name of the sound file, as the detection is given it
Onsets onsets_of_truth(const std::vector<TrueImpact>& truth, const std::string& recording);
/// The truth as an `onsets` table with further columns: contact_time_s, travel_time_s, x_m, y_m, v_mps.
Table truth_table(const std::vector<TrueImpact>& truth, const std::string& recording);
/// `kind,t_s`.
Table others_table(const std::vector<OtherSound>& others);

/// A kind of recording in which impacts are hard to detect: one difficulty each; `rough` combines most of them.
struct HardCase {
  const char* name;
  const char* what;  ///< one line for people
  void (*apply)(SynthesisConfig& config);
};

/// noisy, hum, clicks, knocks, double-hits, clipped, wander, dead-channel, ringing, microphone, rough.
std::span<const HardCase> hard_cases();

/// `config` with the difficulty added; everything else stays as it is.
/// @throws InvalidArgument naming the case and the known ones
SynthesisConfig with_hard_case(SynthesisConfig config, const std::string& name);

}  // namespace bouncelab::synthesis
