// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/closed_loop.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/detection/detect.hpp"
#include "bouncelab/synthesis/synthesize.hpp"

namespace bouncelab::loop {
namespace {

namespace fs = std::filesystem;

/// Where the rows of each drop begin; one more at the end.
std::vector<std::size_t> begins_of_drops(const Impacts& impacts) {
  std::vector<std::size_t> begins;
  for (std::size_t k = 0; k < impacts.rows.size(); ++k)
    if (k == 0 || impacts.rows[k].drop != impacts.rows[k - 1].drop) begins.push_back(k);
  begins.push_back(impacts.rows.size());
  return begins;
}

Impacts rows_of(const Impacts& impacts, std::size_t first, std::size_t last) {
  const auto at = [&](std::size_t k) { return impacts.rows.begin() + static_cast<std::ptrdiff_t>(k); };
  return {{at(first), at(last)}, {}};
}

void keep(const std::vector<float>& samples, const synthesis::SynthesisConfig& config, const fs::path& path) {
  audio::AudioWriter writer(path, {config.rate_hz, 1, config.encoding}, static_cast<std::int64_t>(samples.size()),
                            true);
  writer.write(samples);
  writer.commit();
}

/// A pure function of its arguments but for the recording kept.
/// @param impacts  of this drop alone
RecordingResult run_drop(const Impacts& impacts, const std::string& ball, const DropRecording& recording) {
  RecordingResult result;
  const std::int64_t drop = impacts.rows.front().drop;
  const synthesis::SynthesisConfig config = synthesis::config_of_drop(recording.config, recording.levels, drop);
  const synthesis::SyntheticRecording sound(impacts, config, recording.instrument);
  const std::vector<float> samples = sound.samples_as_read_back();
  result.truth = sound.truth();
  result.sound_s = static_cast<double>(samples.size()) / config.rate_hz;
  result.recording = synthesis::path_of_drop(ball + ".flac", drop).string();
  if (recording.folder) keep(samples, config, *recording.folder / result.recording);
  result.onsets = detection::detect(samples, config.rate_hz, result.recording).onsets;
  return result;
}

}  // namespace

DropRecording drop_recording(const synthesis::SynthesisConfig& config, const Impacts& impacts) {
  if (config.channels.size() != 1)
    throw InvalidArgument("a loop through memory has one sensor, not " + std::to_string(config.channels.size()));
  DropRecording recording;
  recording.config = config;
  recording.config.simulated_positions = false;
  recording.config.n_threads = 1;  // the drops run in parallel
  recording.instrument = synthesis::make_instrument(recording.config);
  const std::vector<std::size_t> begins = begins_of_drops(impacts);
  const std::size_t n = std::min<std::size_t>(kDropsForLevels, begins.size() - 1);
  recording.levels =
      synthesis::SyntheticRecording(rows_of(impacts, 0, begins[n]), recording.config, recording.instrument).levels();
  return recording;
}

std::vector<RecordingResult> run_drops(const Impacts& impacts, const std::string& ball, const DropRecording& recording,
                                       int n_threads, const ProgressCallback& progress) {
  const std::vector<std::size_t> begins = begins_of_drops(impacts);
  std::vector<RecordingResult> drops(begins.size() - 1);
  std::mutex mutex;
  std::size_t n_done = 0;
  parallel_for(drops.size(), n_threads, [&](std::size_t k) {
    drops[k] = run_drop(rows_of(impacts, begins[k], begins[k + 1]), ball, recording);
    const std::lock_guard lock(mutex);
    if (progress) progress(static_cast<double>(++n_done), static_cast<double>(drops.size()));
  });
  return drops;
}

RecordingResult synthesize_together(const Impacts& impacts, const synthesis::SynthesisConfig& config,
                                    const fs::path& file, const ProgressCallback& progress) {
  RecordingResult result;
  result.recording = file.string();
  const auto take = [&](const synthesis::DropTruth& drop) {
    result.truth.insert(result.truth.end(), drop.impacts.begin(), drop.impacts.end());
    result.others.insert(result.others.end(), drop.others.begin(), drop.others.end());
  };
  result.sound_s = synthesis::synthesize(synthesis::drops_of(impacts), config, file, true, take, progress).duration_s;
  return result;
}

void detect_together(RecordingResult& result, int n_threads, const ProgressCallback& progress) {
  result.onsets = std::move(detection::detect({fs::path(result.recording)}, {}, n_threads, progress).front().onsets);
}

Onsets onsets_of(const std::vector<RecordingResult>& recordings) {
  Onsets all;
  std::size_t n = 0;
  for (const RecordingResult& r : recordings) n += r.onsets.size();
  all.reserve(n);
  for (const RecordingResult& r : recordings) all.insert(all.end(), r.onsets.begin(), r.onsets.end());
  return all;
}

Onsets true_onsets_of(const std::vector<RecordingResult>& recordings) {
  Onsets all;
  std::size_t n = 0;
  for (const RecordingResult& r : recordings) n += r.truth.size();
  all.reserve(n);
  for (const RecordingResult& r : recordings) {
    const Onsets truth = synthesis::onsets_of_truth(r.truth, r.recording);
    all.insert(all.end(), truth.begin(), truth.end());
  }
  return all;
}

Table truth_table_of(const std::vector<RecordingResult>& recordings) {
  std::vector<synthesis::TrueImpact> all;
  std::vector<std::string> names;
  for (const RecordingResult& r : recordings) {
    all.insert(all.end(), r.truth.begin(), r.truth.end());
    names.insert(names.end(), r.truth.size(), r.recording);
  }
  Table table = synthesis::truth_table(all, "");
  table.columns.front().values = std::move(names);
  return table;
}

}  // namespace bouncelab::loop
