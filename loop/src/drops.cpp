// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/loop/drops.hpp"

#include <algorithm>
#include <ctime>
#include <mutex>
#include <utility>

#include "bouncelab/audio/audio_writer.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/detection/detect.hpp"

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

double thread_processor_time_s() {
  std::timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// BALL.0017.flac
std::string recording_name(const std::string& ball, std::int64_t drop) {
  return synthesis::path_of_drop(ball + ".flac", drop).string();
}

void keep(const std::vector<float>& samples, const synthesis::SynthesisConfig& config, const fs::path& path) {
  audio::AudioWriter writer(path, {config.rate_hz, 1, config.encoding}, static_cast<std::int64_t>(samples.size()),
                            true);
  writer.write(samples);
  writer.commit();
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

DropResult run_drop(const Impacts& impacts, const std::string& ball, const DropRecording& recording) {
  DropResult result;
  result.drop = impacts.rows.front().drop;
  const double start_s = thread_processor_time_s();
  const synthesis::SynthesisConfig config = synthesis::config_of_drop(recording.config, recording.levels, result.drop);
  const synthesis::SyntheticRecording sound(impacts, config, recording.instrument);
  const std::vector<float> samples = sound.samples_as_read_back();
  result.truth = sound.truth();
  result.sound_s = static_cast<double>(samples.size()) / config.rate_hz;
  const std::string name = recording_name(ball, result.drop);
  if (recording.folder) keep(samples, config, *recording.folder / name);
  const double synthesized_s = thread_processor_time_s();
  result.onsets = detection::detect(samples, config.rate_hz, name).onsets;
  result.synthesize_s = synthesized_s - start_s;
  result.detect_s = thread_processor_time_s() - synthesized_s;
  return result;
}

std::vector<DropResult> run_drops(const Impacts& impacts, const std::string& ball, const DropRecording& recording,
                                  int n_threads, const ProgressCallback& progress) {
  const std::vector<std::size_t> begins = begins_of_drops(impacts);
  std::vector<DropResult> drops(begins.size() - 1);
  std::mutex mutex;
  std::size_t n_done = 0;
  parallel_for(drops.size(), n_threads, [&](std::size_t k) {
    drops[k] = run_drop(rows_of(impacts, begins[k], begins[k + 1]), ball, recording);
    const std::lock_guard lock(mutex);
    if (progress) progress(static_cast<double>(++n_done), static_cast<double>(drops.size()));
  });
  return drops;
}

Onsets onsets_of(const std::vector<DropResult>& drops) {
  Onsets all;
  std::size_t n = 0;
  for (const DropResult& drop : drops) n += drop.onsets.size();
  all.reserve(n);
  for (const DropResult& drop : drops) all.insert(all.end(), drop.onsets.begin(), drop.onsets.end());
  return all;
}

Onsets true_onsets_of(const std::vector<DropResult>& drops, const std::string& ball) {
  Onsets all;
  std::size_t n = 0;
  for (const DropResult& drop : drops) n += drop.truth.size();
  all.reserve(n);
  for (const DropResult& drop : drops) {
    const Onsets truth = synthesis::onsets_of_truth(drop.truth, recording_name(ball, drop.drop));
    all.insert(all.end(), truth.begin(), truth.end());
  }
  return all;
}

Table truth_table_of(const std::vector<DropResult>& drops, const std::string& ball) {
  std::vector<synthesis::TrueImpact> all;
  std::vector<std::string> names;
  for (const DropResult& drop : drops) {
    all.insert(all.end(), drop.truth.begin(), drop.truth.end());
    names.insert(names.end(), drop.truth.size(), recording_name(ball, drop.drop));
  }
  Table table = synthesis::truth_table(all, "");
  table.columns.front().values = std::move(names);
  return table;
}

}  // namespace bouncelab::loop
