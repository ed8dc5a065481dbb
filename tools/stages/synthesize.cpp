// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "bouncelab/audio/sound_file.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/synthesis/synthesize.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "stages/files/provenance.hpp"
#include "stages/files/scratch_folder.hpp"
#include "stages/files/table_file.hpp"

namespace bouncelab::stages {
namespace {

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
      : run_(run), inputs_{impacts}, truth_path_(truth), truth_(run, truth) {}

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
    if (!is_stream(recording_)) write_provenance(recording_, provenance(run_, inputs_, sha256_of_file(recording_)));
    if (others_) others_->finish(inputs_);
    others_.reset();
  }

  const Run& run_;
  std::vector<std::filesystem::path> inputs_;
  std::filesystem::path truth_path_;
  TableWriter truth_;
  std::filesystem::path recording_;
  std::unique_ptr<TableWriter> others_;
};

/// A lossy coding and the file in which it keeps its clock.
struct Codec {
  std::string name, encoder, container;
  int kbits_per_s = 0;
};

/// @param text  aac:64
Codec codec_of(const std::string& text) {
  const std::string_view all = text;
  const std::size_t colon = std::min(all.find(':'), all.size());
  const std::string_view kbits = all.substr(std::min(colon + 1, all.size()));
  for (Codec codec : {Codec{"aac", "aac", "mp4"}, Codec{"mp3", "libmp3lame", "mp3"}, Codec{"opus", "libopus", "ogg"},
                      Codec{"vorbis", "libvorbis", "ogg"}}) {
    const bool is_number = parse_number(kbits, codec.kbits_per_s) == std::errc{};
    if (codec.name == all.substr(0, colon) && is_number && codec.kbits_per_s >= 6 && codec.kbits_per_s <= 512)
      return codec;
  }
  throw InvalidArgument("--codec: '" + printable(text) +
                        "' is not NAME:KBITS, aac, mp3, opus or vorbis and 6 to 512 kbit/s: aac:64");
}

std::filesystem::path ffmpeg_for_codec() {
  if (const auto found = find_program("ffmpeg")) return *found;
  throw FileError("--codec",
                  "needs ffmpeg; install it (Debian, Ubuntu: apt install ffmpeg; macOS: brew install ffmpeg)");
}

/// Writes what the codec leaves of a sound: as long, and at the same times, since the container tells the decoder what
/// the encoder added.
void write_coded(const std::filesystem::path& sound, const Codec& codec, const audio::AudioSpec& spec,
                 std::int64_t n_frames, const std::filesystem::path& out, bool may_replace) {
  const std::filesystem::path ffmpeg = ffmpeg_for_codec();
  const std::string coded = sound.string() + "." + codec.container, n_channels = std::to_string(spec.n_channels);
  const ProgramResult encoded =
      run_program(ffmpeg,
                  {"-nostdin", "-v", "error", "-i", sound.string(), "-ac", n_channels, "-c:a", codec.encoder, "-b:a",
                   std::to_string(codec.kbits_per_s) + "k", "-f", codec.container, coded},
                  out.string(), -1, {});
  if (!encoded.ended_well)
    throw InvalidArgument("--codec: ffmpeg cannot encode " + n_channels + " channels at " +
                          std::to_string(spec.rate_hz) + " Hz by " + codec.encoder + " at " +
                          std::to_string(codec.kbits_per_s) + " kbit/s: " + first_complaint(encoded.complaints));
  ChildProcess decoder(ffmpeg,
                       {"-nostdin", "-v", "error", "-i", coded, "-ar", std::to_string(spec.rate_hz), "-ac", n_channels,
                        "-f", "f32le", "pipe:1"},
                       out.string(), -1, {});
  audio::AudioWriter writer(out, spec, n_frames, may_replace);
  std::vector<float> piece(static_cast<std::size_t>(spec.n_channels) << 14);
  std::int64_t left = n_frames * spec.n_channels;
  const auto write_piece = [&](std::size_t n_samples) {
    const std::size_t n = std::min(n_samples, static_cast<std::size_t>(left));
    writer.write(std::span<const float>(piece).first(n));
    left -= static_cast<std::int64_t>(n);
  };
  std::size_t n_decoded = 1;
  while (left > 0 && n_decoded > 0) {
    n_decoded = decoder.read(std::as_writable_bytes(std::span(piece))) / sizeof(float);
    write_piece(n_decoded);
  }
  if (left > 0 && !decoder.ended_well())
    throw FileError(out.string(), "ffmpeg cannot decode what it encoded: " + first_complaint(decoder.complaints()));
  std::fill(piece.begin(), piece.end(), 0.0F);  // an encoder may cut off the last frames
  while (left > 0) write_piece(piece.size());
  writer.commit();
}

synthesis::SynthesisResult make_sound(const SynthesizeOptions& options, const synthesis::SynthesisConfig& config,
                                      const Impacts& impacts, TruthFiles& truth, const Run& run) {
  const std::filesystem::path out = options.out;
  const synthesis::DropSource drops = synthesis::drops_of(impacts);
  if (options.each_drop)
    return synthesis::synthesize_each_drop(
        drops, config, out, run.common.force, [&](const synthesis::DropTruth& drop) { truth.add(drop); },
        progress_line(run, "synthesize", "impacts"));
  const auto synthesize_to = [&](const std::filesystem::path& sound) {
    const auto add_truth = [&](const synthesis::DropTruth& drop) { truth.add({out, drop.impacts, drop.others}); };
    return synthesis::synthesize(drops, config, sound, run.common.force, add_truth,
                                 progress_line(run, "synthesize", "s of sound"));
  };
  if (options.codec == "none") return synthesize_to(out);
  const Codec codec = codec_of(options.codec);
  ffmpeg_for_codec();
  const audio::AudioSpec spec{config.rate_hz, static_cast<int>(config.channels.size()), config.encoding};
  audio::validate(out, spec);
  const ScratchFolder scratch;
  const std::filesystem::path sound = scratch.path() / "sound.wav";
  synthesis::SynthesisResult result = synthesize_to(sound);
  write_coded(sound, codec, spec, std::llround(result.duration_s * config.rate_hz), out, run.common.force);
  return result;
}

}  // namespace

std::vector<Section> scene_sections(Scene& scene, bool with_codec) {
  const std::vector<std::string> stages{"synthesize"};
  std::vector<Section> sections{ball_section(scene.world, "", {"simulate", "synthesize"}),
                                section_of(scene.simulate, "Ball, ground and drops", {"simulate"}),
                                section_of(scene.synthesize, "Sound", stages), disturbances_section(scene.synthesize)};
  sections.back().stages = stages;
  if (with_codec) sections.push_back(codec_section(scene.synthesize, stages));
  return sections;
}

void set_scene(Scene& scene, CommonOptions& common, const loop::Settings& settings) {
  const std::vector<Section> sections = scene_sections(scene, true);
  for (const auto& [name, value] : settings) {
    if (name != "seed" && !option_named(sections, name))
      throw InvalidArgument("--" + name + ": has one value in a run, not a list");
    set_option(name == "seed" ? std::vector{common_section(common)} : sections, name, {value});
  }
}

std::vector<Section> sections_of(SynthesizeOptions& options) {
  return {ball_section(options.world, "those of the impacts where they were simulated, else steel:6mm on glass"),
          section_of(options, "Sound"), disturbances_section(options)};
}

Section codec_section(SynthesizeOptions& options, std::vector<std::string> stages) {
  static constexpr Member option[]{
      member<&SynthesizeOptions::codec>(
          "codec", "What is left of the sound by aac, mp3, opus or vorbis, by ffmpeg: aac:64 for 64 kbit/s")
          .looks_like("NAME:KBITS")};
  return {"", option, &options, std::move(stages)};
}

Outcome run_synthesize(const SynthesizeOptions& options, const Run& run) {
  const synthesis::SynthesisConfig config = synthesis_config(options, run.common.seed, run.common.n_threads);
  const std::filesystem::path out = options.out;
  if (is_stream(out) && options.truth.empty())
    throw InvalidArgument("--out " + printable(options.out) + ": no truth can lie beside it; name one with --truth");
  if (options.codec != "none" && (is_stream(out) || options.each_drop))
    throw InvalidArgument("--codec: goes with one file, not with " +
                          std::string(options.each_drop ? "--each-drop" : "a stream"));
  const std::filesystem::path truth =
      options.truth.empty() ? beside(out, ".truth.csv") : std::filesystem::path(options.truth);
  const Impacts impacts =
      impacts_from_table(read_table(options.impacts, impact_columns()), input_name(options.impacts));
  std::vector<std::filesystem::path> outputs, others;
  if (!options.each_drop) outputs.push_back(out);
  for (const Impact& impact : impacts.rows)
    if (options.each_drop && (&impact == impacts.rows.data() || (&impact)[-1].drop != impact.drop))
      outputs.push_back(synthesis::path_of_drop(out, impact.drop));
  for (const std::filesystem::path& recording : outputs) others.push_back(others_path(recording, truth));
  outputs.push_back(truth);
  check_files(run, {options.impacts}, outputs, others);
  TruthFiles files(run, truth, options.impacts);
  synthesis::SynthesisResult result;
  try {
    result = make_sound(options, config, impacts, files, run);
  } catch (const synthesis::OffThePlate& error) {
    throw InvalidArgument(std::string(error.what()) + ": simulate --plate-size X,Y, or --positions drawn here");
  }
  files.finish();

  Outcome outcome;
  outcome.notes = joined(notes_on_provenance({options.impacts}), result.notes);
  outcome.result = object_of(result);
  outcome.result.emplace_back("ball", value_of(config.ball));
  outcome.result.emplace_back("plate", value_of(contact_material(config.ground)));
  outcome.text =
      fmt::format("{:.1f} s of sound with {} impacts in {}, truth in {}\nball: {} on {}\n", result.duration_s,
                  result.n_impacts, options.each_drop ? std::to_string(result.n_files) + " files" : out.string(),
                  truth.string(), bouncelab::describe(config.ball), plate_text(contact_material(config.ground)));
  return outcome;
}

}  // namespace bouncelab::stages
