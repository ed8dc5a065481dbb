// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/synthesize_command.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <string_view>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/output_file.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/loop/records.hpp"
#include "bouncelab/synthesis/synthesize.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "files/impact_file.hpp"
#include "files/provenance.hpp"
#include "files/run_parts.hpp"
#include "files/table_file.hpp"
#include "json/stage_json.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

audio::SampleEncoding encoding_of(const std::string& bits) {
  if (bits == "16") return audio::SampleEncoding::pcm16;
  if (bits == "32") return audio::SampleEncoding::pcm32;
  return bits == "float" ? audio::SampleEncoding::float32 : audio::SampleEncoding::pcm24;
}

/// False where the text is not one finite decimal number.
bool read_number(std::string_view text, double& value) {
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

synthesis::Channel channel_of(const std::string& text, double default_z_m) {
  synthesis::Channel channel;
  channel.z_m = default_z_m;
  double* const fields[] = {&channel.x_m, &channel.y_m, &channel.z_m, &channel.gain};
  std::string_view rest = text;
  for (std::size_t n = 0; n < std::size(fields); ++n) {
    const auto comma = rest.find(',');
    if (!read_number(rest.substr(0, comma), *fields[n])) break;
    if (comma == std::string_view::npos && n >= 1) return channel;
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  throw InvalidArgument("--channel: '" + printable(text) +
                        "' is not X,Y[,Z[,GAIN]], finite decimal numbers, in metres");
}

std::filesystem::path beside(const std::filesystem::path& out, const std::string& ending) {
  return out.parent_path() / (out.stem().string() + ending);
}

/// What else sounds in a recording: beside it, or beside the truth where nothing can lie beside the recording.
std::filesystem::path others_path(const std::filesystem::path& recording, const std::filesystem::path& truth) {
  return beside(is_stream(recording) ? truth : recording, ".others.csv");
}

/// Writes the truth of all recordings, and beside each recording provenance and what else sounds in it.
class TruthFiles {
 public:
  TruthFiles(const Run& run, const std::filesystem::path& truth, const std::filesystem::path& impacts)
      : run_(run), inputs_{impacts}, provenance_(provenance(run, inputs_)), truth_path_(truth), truth_(run, truth) {}

  void add(const synthesis::DropTruth& drop) {
    if (recording_ != drop.recording) {
      finish_recording();
      recording_ = drop.recording;
    }
    truth_.add(synthesis::truth_table(drop.impacts, drop.recording.string()));
    if (drop.others.empty()) return;
    if (!others_) others_ = std::make_unique<TableWriter>(run_, others_path(recording_, truth_path_));
    others_->add(synthesis::others_table(drop.others));
  }
  void finish() {
    finish_recording();
    truth_.finish(inputs_);
  }

 private:
  void finish_recording() {
    if (recording_.empty()) return;
    write_provenance(recording_, provenance_);
    if (others_) others_->finish(inputs_);
    others_.reset();
  }

  const Run& run_;
  std::vector<std::filesystem::path> inputs_;
  std::string provenance_;
  std::filesystem::path truth_path_;
  TableWriter truth_;
  std::filesystem::path recording_;
  std::unique_ptr<TableWriter> others_;
};

[[noreturn]] void refuse(const synthesis::OffThePlate& error) {
  throw InvalidArgument(std::string(error.what()) + ": simulate --plate-size X,Y, or --positions drawn here");
}

synthesis::SynthesisResult make_sound(const SynthesizeOptions& options, const synthesis::SynthesisConfig& config,
                                      TruthFiles& truth, const Run& run) {
  try {
    return synthesis::synthesize(
        impact_file(options.impacts), config, options.out, run.common.force,
        [&](const synthesis::DropTruth& drop) { truth.add(drop); }, progress_line(run, "synthesize", "s of sound"));
  } catch (const synthesis::OffThePlate& error) {
    refuse(error);
  }
}

void make_each_drop(const SynthesizeOptions& options, const synthesis::SynthesisConfig& config, bool may_replace,
                    const synthesis::DropChoice& is_wanted, const synthesis::DropFileSink& sink, const Run& run) {
  try {
    synthesis::synthesize_each_drop(impact_file(options.impacts), config, options.out, may_replace, is_wanted, sink,
                                    progress_line(run, "synthesize", "impacts"));
  } catch (const synthesis::OffThePlate& error) {
    refuse(error);
  }
}

/// The recordings of --each-drop, which are its items by their names.
std::vector<std::string> recordings_of(const SynthesizeOptions& options) {
  const synthesis::DropSource drops = impact_file(options.impacts);
  std::vector<std::string> recordings;
  Impacts drop;
  for (std::int64_t k = 0; drops(k, drop); ++k)
    recordings.push_back(synthesis::path_of_drop(options.out, drop.rows.front().drop).string());
  return recordings;
}

/// The recordings of the shard, and the records of their truth in its part.
Outcome run_part(const SynthesizeOptions& options, const synthesis::SynthesisConfig& config, const Run& run) {
  if (!options.each_drop)
    throw InvalidArgument("--shard: one recording cannot be divided; --each-drop makes one of each drop");
  const std::vector<std::string> recordings = recordings_of(options);
  PartFile part(run, options.out, run_identity(run, {options.impacts}, {"impacts"}), recordings,
                [](const std::string& recording, std::string_view) { return std::filesystem::exists(recording); });
  const std::set<std::size_t> pending(part.pending().begin(), part.pending().end());
  if (!pending.empty())
    make_each_drop(
        options, config, run.common.force || part.goes_on(),
        [&](std::int64_t k) { return pending.count(static_cast<std::size_t>(k)) > 0; },
        [&](std::int64_t k, const synthesis::DropTruth& truth, const synthesis::SynthesisResult& of_file) {
          part.keep(static_cast<std::size_t>(k), loop::to_record(truth, of_file));
        },
        run);
  return part.finish({options.impacts}, "recordings");
}

/// Each drop: synthesized, or already there from the parts of the run.
synthesis::SynthesisResult each_drop(const SynthesizeOptions& options, const synthesis::SynthesisConfig& config,
                                     TruthFiles& truth, const Run& run) {
  std::vector<synthesis::SynthesisResult> files;
  const auto take = [&](std::int64_t, const synthesis::DropTruth& drop, const synthesis::SynthesisResult& of_file) {
    truth.add(drop);
    files.push_back(of_file);
  };
  if (run.parts.empty()) {
    make_each_drop(options, config, run.common.force, {}, take, run);
    return synthesis::all_files(files, config);
  }
  const std::vector<std::string> recordings = recordings_of(options);
  RunParts parts(run, run_identity(run, {options.impacts}, {"impacts"}), recordings);
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    if (!std::filesystem::exists(recordings[k]))
      throw FileError(recordings[k], "is missing; run the shards again, which make what is missing");
    const loop::SynthesizedFile file = loop::synthesized_file_from_record(parts.record(k), recordings[k]);
    take(static_cast<std::int64_t>(k), file.truth, file.of_file);
  }
  return synthesis::all_files(files, config);
}

}  // namespace

synthesis::SynthesisConfig synthesis_config(const SynthesizeOptions& options, const CommonOptions& common) {
  synthesis::SynthesisConfig config = options.config;
  config.seed = common.seed;
  config.n_threads = common.n_threads;
  if (const std::optional<Ball> ball = ball_of(options.world)) config.ball = *ball;
  if (const std::optional<Material> plate = plate_of(options.world)) config.ground = synthesis::ground_of(*plate);
  config.encoding = encoding_of(options.bits);
  config.simulated_positions = options.positions == "simulated";
  const bool by_air = options.sensor == "microphone";
  if (by_air) config.sensor = synthesis::microphone();
  const double default_z_m = by_air ? 0.3 : 0.0;
  config.channels.front().z_m = default_z_m;
  if (!options.channels.empty()) config.channels.clear();
  for (const std::string& text : options.channels) config.channels.push_back(channel_of(text, default_z_m));
  return options.hard_case.empty() ? config : synthesis::with_hard_case(config, options.hard_case);
}

Outcome run_synthesize(const SynthesizeOptions& options, const Run& run) {
  const synthesis::SynthesisConfig config = synthesis_config(options, run.common);
  if (run.shard) return run_part(options, config, run);
  const std::filesystem::path out = options.out;
  if (is_stream(out) && options.truth.empty())
    throw InvalidArgument("--out " + printable(options.out) + ": no truth can lie beside it; name one with --truth");
  const std::filesystem::path truth =
      options.truth.empty() ? beside(out, ".truth.csv") : std::filesystem::path(options.truth);
  check_files(
      run, {options.impacts},
      options.each_drop ? std::vector<std::filesystem::path>{truth} : std::vector<std::filesystem::path>{out, truth},
      {others_path(out, truth)});
  TruthFiles files(run, truth, options.impacts);
  const synthesis::SynthesisResult result =
      options.each_drop ? each_drop(options, config, files, run) : make_sound(options, config, files, run);
  files.finish();

  Outcome outcome;
  outcome.warnings = result.warnings;
  outcome.json = synthesize_json(result, config.ball, contact_material(config.ground));
  outcome.text =
      fmt::format("{:.1f} s of sound with {} impacts in {}, truth in {}\nball: {} on {}\n", result.duration_s,
                  result.n_impacts, options.each_drop ? std::to_string(result.n_files) + " files" : out.string(),
                  truth.string(), bouncelab::describe(config.ball), plate_text(contact_material(config.ground)));
  return outcome;
}

}  // namespace bouncelab::cli
