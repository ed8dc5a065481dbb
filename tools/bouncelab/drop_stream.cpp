// SPDX-License-Identifier: GPL-3.0-or-later
#include "drop_stream.hpp"

#include <algorithm>
#include <ctime>
#include <mutex>
#include <set>
#include <utility>

#include "bouncelab/audio/audio_writer.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/detection/detect.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDropsForLevels = 40;

std::string recording_name(const std::string& ball, std::int64_t drop) {
  return synthesis::path_of_drop(ball + ".flac", drop).string();
}

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

void keep(const std::vector<double>& samples, const synthesis::SynthesisConfig& config, const fs::path& path) {
  audio::AudioWriter writer(path, {config.rate_hz, 1, config.encoding}, static_cast<std::int64_t>(samples.size()),
                            true);
  writer.write(samples);
  writer.commit();
}

template <class Row, class Value>
Json column(const std::vector<Row>& rows, Value Row::*member) {
  Json values = Json::array();
  for (const Row& row : rows) values.push_back(row.*member);
  return values;
}

template <class Row>
Json column(const std::vector<Row>& rows, std::optional<double> Row::*member) {
  Json values = Json::array();
  for (const Row& row : rows) values.push_back(row.*member ? Json(*(row.*member)) : Json(nullptr));
  return values;
}

template <class Row>
Json column(const std::vector<Row>& rows, Flags Row::*member) {
  Json values = Json::array();
  for (const Row& row : rows) values.push_back((row.*member).text());
  return values;
}

template <class Row, class Value>
void take(const Json& values, std::vector<Row>& rows, Value Row::*member) {
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k].*member = values.at(k).get<Value>();
}

template <class Row>
void take(const Json& values, std::vector<Row>& rows, std::optional<double> Row::*member) {
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (!values.at(k).is_null()) rows[k].*member = values.at(k).get<double>();
}

template <class Row>
void take(const Json& values, std::vector<Row>& rows, Flags Row::*member) {
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k].*member = Flags::from_text(values.at(k).get<std::string>());
}

// the numbers of an impact that a journal keeps; `use` gets name and member
template <class Use>
void for_each_number(const Use& use, const Onset*) {
  use("t_s", &Onset::t_s);
  use("sigma_t_s", &Onset::sigma_t_s);
  use("amplitude", &Onset::amplitude);
  use("snr_db", &Onset::snr_db);
  use("drop", &Onset::drop);
  use("impact", &Onset::impact);
  use("flags", &Onset::flags);
}

template <class Use>
void for_each_number(const Use& use, const synthesis::TrueImpact*) {
  use("t_s", &synthesis::TrueImpact::t_s);
  use("sigma_t_s", &synthesis::TrueImpact::sigma_t_s);
  use("amplitude", &synthesis::TrueImpact::amplitude);
  use("snr_db", &synthesis::TrueImpact::snr_db);
  use("drop", &synthesis::TrueImpact::drop);
  use("impact", &synthesis::TrueImpact::impact);
  use("flags", &synthesis::TrueImpact::flags);
  use("contact_time_s", &synthesis::TrueImpact::contact_time_s);
  use("travel_time_s", &synthesis::TrueImpact::travel_time_s);
  use("x_m", &synthesis::TrueImpact::x_m);
  use("y_m", &synthesis::TrueImpact::y_m);
  use("v_mps", &synthesis::TrueImpact::v_mps);
}

template <class Row>
Json columns(const std::vector<Row>& rows) {
  Json json = Json::object();
  for_each_number([&](const char* name, auto member) { json[name] = column(rows, member); },
                  static_cast<const Row*>(nullptr));
  return json;
}

template <class Row>
std::vector<Row> rows_from(const Json& json) {
  std::vector<Row> rows(json.at("t_s").size());
  for_each_number([&](const char* name, auto member) { take(json.at(name), rows, member); },
                  static_cast<const Row*>(nullptr));
  return rows;
}

}  // namespace

SoundStage make_sound_stage(const synthesis::SynthesisConfig& config, const Impacts& impacts) {
  if (config.channels.size() != 1)
    throw InvalidArgument("--channel: a loop through memory has one sensor, not " +
                          std::to_string(config.channels.size()) + "; give one, or use --preset quick without lists");
  SoundStage stage;
  stage.config = config;
  stage.config.simulated_positions = false;
  stage.config.n_threads = 1;  // drops are what runs side by side
  stage.instrument = synthesis::make_instrument(stage.config);
  const std::vector<std::size_t> begins = begins_of_drops(impacts);
  const std::size_t n = std::min(kDropsForLevels, begins.size() - 1);
  stage.levels = synthesis::SyntheticRecording(rows_of(impacts, 0, begins[n]), stage.config, stage.instrument).levels();
  return stage;
}

Json to_json(const std::string& ball, const HeardDrop& heard) {
  return {{"ball", ball},
          {"drop", heard.drop},
          {"sound_s", heard.sound_s},
          {"synthesize_s", heard.synthesize_s},
          {"detect_s", heard.detect_s},
          {"truth", columns(heard.truth)},
          {"onsets", columns(heard.onsets)}};
}

HeardDrop heard_drop_from_json(const Json& json) {
  HeardDrop heard;
  heard.drop = json.at("drop").get<std::int64_t>();
  heard.sound_s = json.at("sound_s").get<double>();
  heard.synthesize_s = json.at("synthesize_s").get<double>();
  heard.detect_s = json.at("detect_s").get<double>();
  heard.truth = rows_from<synthesis::TrueImpact>(json.at("truth"));
  heard.onsets = rows_from<Onset>(json.at("onsets"));
  const std::string name = recording_name(json.at("ball").get<std::string>(), heard.drop);
  for (Onset& onset : heard.onsets) onset.recording = name;
  return heard;
}

HeardDrop hear_drop(const Impacts& impacts, const std::string& ball, const SoundStage& stage) {
  HeardDrop heard;
  heard.drop = impacts.rows.front().drop;
  const double start_s = thread_processor_time_s();
  const synthesis::SynthesisConfig config = synthesis::config_of_drop(stage.config, stage.levels, heard.drop);
  const synthesis::SyntheticRecording recording(impacts, config, stage.instrument);
  const std::vector<double> samples = recording.samples();
  heard.truth = recording.truth();
  heard.sound_s = static_cast<double>(samples.size()) / config.rate_hz;
  const std::string name = recording_name(ball, heard.drop);
  if (stage.keep_sound) keep(samples, config, stage.folder / name);
  const std::vector<float> read_back = audio::as_read_back(samples, config.encoding);
  const double sounded_s = thread_processor_time_s();
  heard.onsets = detection::detect(read_back, config.rate_hz, name).onsets;
  heard.synthesize_s = sounded_s - start_s;
  heard.detect_s = thread_processor_time_s() - sounded_s;
  return heard;
}

std::vector<HeardDrop> hear_drops(const Impacts& impacts, const std::string& ball, const SoundStage& stage,
                                  std::vector<HeardDrop> heard, RunJournal* journal, const Run& run) {
  std::set<std::int64_t> done;
  for (const HeardDrop& drop : heard) done.insert(drop.drop);
  const std::vector<std::size_t> begins = begins_of_drops(impacts);
  std::vector<std::size_t> pending;
  for (std::size_t k = 0; k + 1 < begins.size(); ++k)
    if (done.count(impacts.rows[begins[k]].drop) == 0) pending.push_back(k);

  const ProgressCallback progress = progress_line(run, "hear the " + ball + " ball", "drops");
  std::mutex mutex;
  std::size_t n_done = 0;
  const auto finish = [&](HeardDrop drop) {
    if (journal != nullptr) journal->append(to_json(ball, drop));
    const std::lock_guard lock(mutex);
    heard.push_back(std::move(drop));
    progress(static_cast<double>(++n_done), static_cast<double>(pending.size()));
  };
  parallel_for(pending.size(), run.common.n_threads, [&](std::size_t k) {
    const std::size_t drop = pending[k];
    finish(hear_drop(rows_of(impacts, begins[drop], begins[drop + 1]), ball, stage));
  });
  std::sort(heard.begin(), heard.end(), [](const HeardDrop& a, const HeardDrop& b) { return a.drop < b.drop; });
  return heard;
}

Onsets onsets_of(const std::vector<HeardDrop>& drops) {
  Onsets all;
  for (const HeardDrop& drop : drops) all.insert(all.end(), drop.onsets.begin(), drop.onsets.end());
  return all;
}

Onsets true_onsets_of(const std::vector<HeardDrop>& drops, const std::string& ball) {
  Onsets all;
  for (const HeardDrop& drop : drops) {
    const Onsets truth = synthesis::onsets_of_truth(drop.truth, recording_name(ball, drop.drop));
    all.insert(all.end(), truth.begin(), truth.end());
  }
  return all;
}

Table truth_table_of(const std::vector<HeardDrop>& drops, const std::string& ball) {
  std::vector<synthesis::TrueImpact> all;
  std::vector<std::string> names;
  for (const HeardDrop& drop : drops) {
    all.insert(all.end(), drop.truth.begin(), drop.truth.end());
    names.insert(names.end(), drop.truth.size(), recording_name(ball, drop.drop));
  }
  Table table = synthesis::truth_table(all, "");
  table.columns.front().values = std::move(names);
  return table;
}

}  // namespace bouncelab::cli
