// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <future>

#include "bouncelab/acoustic/synthesis.hpp"
#include "bouncelab/core/random.hpp"
#include "in_parallel.hpp"
#include "instrument.hpp"

namespace bouncelab {
namespace {

std::vector<std::string> warnings_of(const SyntheticRecording& recording, const SynthesisConfig& config) {
  std::vector<std::string> warnings;
  const double nyquist_hz = 0.5 * config.rate_hz;
  if (nyquist_hz < config.max_mode_hz) {
    std::vector<double> left_out_hz;
    const PlateModes plate(config.ground, config.max_mode_hz);
    for (const PlateMode& mode : plate.modes())
      if (mode.frequency_hz >= nyquist_hz) left_out_hz.push_back(mode.frequency_hz);
    const auto [lowest, highest] = std::minmax_element(left_out_hz.begin(), left_out_hz.end());
    if (!left_out_hz.empty())
      warnings.push_back(std::to_string(left_out_hz.size()) + " modes from " + std::to_string(std::lround(*lowest)) +
                         " to " + std::to_string(std::lround(*highest)) + " Hz are left out: a rate of " +
                         std::to_string(config.rate_hz) + " Hz cannot hold them");
  }
  const auto n_clipped = std::count_if(recording.truth().begin(), recording.truth().end(),
                                       [](const TrueImpact& impact) { return impact.flags == "clipped"; });
  if (n_clipped > 0) warnings.push_back(std::to_string(n_clipped) + " impacts are clipped at full scale");
  return warnings;
}

SynthesisResult write_recording(const SyntheticRecording& recording, const Instrument& instrument,
                                const SynthesisConfig& config, const std::filesystem::path& out, bool may_replace,
                                const ProgressCallback& progress) {
  const AudioSpec spec{config.rate_hz, static_cast<int>(config.channels.size()), config.encoding};
  AudioWriter writer(out, spec, recording.n_frames(), may_replace);
  const double duration_s = static_cast<double>(recording.n_frames()) / config.rate_hz;
  const std::int64_t n_threads = resolved_threads(config.n_threads);
  for (std::int64_t first = 0; first < recording.n_segments(); first += n_threads) {
    std::vector<std::future<std::vector<double>>> batch;
    for (std::int64_t k = first; k < std::min(first + n_threads, recording.n_segments()); ++k)
      batch.push_back(std::async(n_threads == 1 ? std::launch::deferred : std::launch::async,
                                 [&recording, k] { return recording.segment(k); }));
    for (auto& segment : batch) writer.write(segment.get());
    const auto n_done = static_cast<double>((first + n_threads) * recording.segment_frames());
    if (progress) progress(std::min(duration_s, n_done / config.rate_hz), duration_s);
  }
  writer.commit();
  return {recording.truth(),
          recording.others(),
          recording.levels(),
          duration_s,
          static_cast<int>(instrument.plate().modes().size()),
          warnings_of(recording, config)};
}

/// The impacts of one drop, rows first ... last - 1.
Impacts one_drop(const Impacts& impacts, std::size_t first, std::size_t last) {
  const auto at = [](std::size_t k) { return static_cast<std::ptrdiff_t>(k); };
  Impacts drop;
  drop.rows.assign(impacts.rows.begin() + at(first), impacts.rows.begin() + at(last));
  if (!impacts.states.empty())
    drop.states.assign(impacts.states.begin() + at(first), impacts.states.begin() + at(last));
  return drop;
}

void check_file(const std::filesystem::path& out, const SynthesisConfig& config) {
  validate(out, {config.rate_hz, static_cast<int>(config.channels.size()), config.encoding});
}

}  // namespace

SynthesisResult synthesize(const Impacts& impacts, const SynthesisConfig& config, const std::filesystem::path& out,
                           bool may_replace, const ProgressCallback& progress) {
  check_file(out, config);
  const auto instrument = make_instrument(config);
  const SyntheticRecording recording(impacts, config, instrument);
  return write_recording(recording, *instrument, config, out, may_replace, progress);
}

SynthesisConfig config_of_drop(const SynthesisConfig& config, const Levels& levels, std::int64_t drop) {
  SynthesisConfig own = config;
  own.levels = levels;
  own.seed = philox_block(config.seed, RandomStream::noise, 1ull << 63, static_cast<std::uint64_t>(drop))[0];
  return own;
}

std::filesystem::path path_of_drop(const std::filesystem::path& out, std::int64_t drop) {
  std::string number = std::to_string(drop);
  if (number.size() < 4) number.insert(0, 4 - number.size(), '0');
  return out.parent_path() / (out.stem().string() + "." + number + out.extension().string());
}

std::vector<DropRecording> synthesize_each_drop(const Impacts& impacts, const SynthesisConfig& config,
                                                const std::filesystem::path& out, bool may_replace,
                                                const ProgressCallback& progress) {
  check_file(out, config);
  const auto instrument = make_instrument(config);
  const Levels levels = SyntheticRecording(impacts, config, instrument).levels();
  std::vector<DropRecording> recordings;
  for (std::size_t first = 0, last = 0; first < impacts.rows.size(); first = last) {
    const std::int64_t drop = impacts.rows[first].drop;
    while (last < impacts.rows.size() && impacts.rows[last].drop == drop) ++last;
    const SynthesisConfig of_drop = config_of_drop(config, levels, drop);
    const SyntheticRecording recording(one_drop(impacts, first, last), of_drop, instrument);
    const std::filesystem::path path = path_of_drop(out, drop);
    recordings.push_back({path, write_recording(recording, *instrument, of_drop, path, may_replace, {})});
    if (progress) progress(static_cast<double>(last), static_cast<double>(impacts.rows.size()));
  }
  return recordings;
}

Table truth_table(const std::vector<TrueImpact>& truth, const std::string& recording) {
  const auto reals = [&](const char* name, auto member) {
    std::vector<double> values;
    for (const TrueImpact& impact : truth) values.push_back(impact.*member);
    return Column{name, std::move(values)};
  };
  std::vector<std::int64_t> drop, impact;
  std::vector<std::string> flags;
  for (const TrueImpact& row : truth) {
    drop.push_back(row.drop);
    impact.push_back(row.impact);
    flags.push_back(row.flags);
  }
  return {{{"recording", std::vector<std::string>(truth.size(), recording)},
           {"drop", std::move(drop)},
           {"impact", std::move(impact)},
           reals("t_s", &TrueImpact::t_s),
           reals("sigma_t_s", &TrueImpact::sigma_t_s),
           reals("amplitude", &TrueImpact::amplitude),
           reals("snr_db", &TrueImpact::snr_db),
           {"flags", std::move(flags)},
           reals("contact_time_s", &TrueImpact::contact_time_s),
           reals("travel_time_s", &TrueImpact::travel_time_s),
           reals("x_m", &TrueImpact::x_m),
           reals("y_m", &TrueImpact::y_m),
           reals("v_mps", &TrueImpact::v_mps)}};
}

Table others_table(const std::vector<OtherSound>& others) {
  std::vector<std::string> kind;
  std::vector<double> t_s;
  for (const OtherSound& sound : others) {
    kind.push_back(sound.kind);
    t_s.push_back(sound.t_s);
  }
  return {{{"kind", std::move(kind)}, {"t_s", std::move(t_s)}}};
}

}  // namespace bouncelab
