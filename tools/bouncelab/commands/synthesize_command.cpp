// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/synthesize_command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <sstream>

#include "bouncelab/core/error.hpp"
#include "bouncelab/synthesis/hard_cases.hpp"
#include "bouncelab/synthesis/synthesize.hpp"
#include "files/impact_file.hpp"
#include "files/provenance.hpp"
#include "files/table_file.hpp"
#include "progress_line.hpp"

namespace bouncelab::cli {
namespace {

synthesis::GroundPreset preset_of(const std::string& name) {
  if (name == "sic") return synthesis::GroundPreset::sic;
  return name == "vitreloy" ? synthesis::GroundPreset::vitreloy : synthesis::GroundPreset::glass;
}

audio::SampleEncoding encoding_of(const std::string& bits) {
  if (bits == "16") return audio::SampleEncoding::pcm16;
  if (bits == "32") return audio::SampleEncoding::pcm32;
  return bits == "float" ? audio::SampleEncoding::float32 : audio::SampleEncoding::pcm24;
}

synthesis::Channel channel_of(const std::string& text, double default_z_m) {
  synthesis::Channel channel;
  channel.z_m = default_z_m;
  double* const fields[] = {&channel.x_m, &channel.y_m, &channel.z_m, &channel.gain};
  std::size_t n = 0;
  std::istringstream in(text);
  for (std::string cell; std::getline(in, cell, ','); ++n)
    if (n >= std::size(fields) || !CLI::detail::lexical_cast(cell, *fields[n]))
      throw InvalidArgument("--channel: '" + text + "' is not X,Y[,Z[,GAIN]] in metres");
  if (n < 2) throw InvalidArgument("--channel: '" + text + "' is not X,Y[,Z[,GAIN]] in metres");
  return channel;
}

std::filesystem::path beside(const std::filesystem::path& out, const std::string& ending) {
  return out.parent_path() / (out.stem().string() + ending);
}

std::string hard_case_help() {
  std::string help = "Something hard to hear impacts in:";
  for (const synthesis::HardCase& hard : synthesis::hard_cases()) help += "\n  " + hard.name + ": " + hard.what;
  return help;
}

Json summary_of(const synthesis::SynthesisResult& result) {
  return {{"n_impacts", result.n_impacts},
          {"n_other_sounds", result.n_other_sounds},
          {"n_modes", result.n_modes},
          {"n_files", result.n_files},
          {"duration_s", result.duration_s},
          {"noise_rms", result.levels.noise_rms},
          {"weakest_peak", result.levels.weakest_peak},
          {"gain", result.levels.gain}};
}

/// Writes the truth of all recordings, and beside each recording provenance and what else sounds in it.
class TruthFiles {
 public:
  TruthFiles(const Run& run, const std::filesystem::path& truth, const std::filesystem::path& impacts)
      : run_(run), inputs_{impacts}, truth_(run, truth, inputs_) {}

  void add(const synthesis::DropTruth& drop) {
    if (recording_ != drop.recording) {
      finish_recording();
      recording_ = drop.recording;
    }
    truth_.add(synthesis::truth_table(drop.impacts, drop.recording.string()));
    if (drop.others.empty()) return;
    if (!others_) others_ = std::make_unique<TableWriter>(run_, beside(recording_, ".others.csv"), inputs_);
    others_->add(synthesis::others_table(drop.others));
  }
  void finish() {
    finish_recording();
    truth_.finish();
  }

 private:
  void finish_recording() {
    if (recording_.empty()) return;
    write_provenance(run_, recording_, inputs_);
    if (others_) others_->finish();
    others_.reset();
  }

  const Run& run_;
  std::vector<std::filesystem::path> inputs_;
  TableWriter truth_;
  std::filesystem::path recording_;
  std::unique_ptr<TableWriter> others_;
};

synthesis::SynthesisResult make_sound(const SynthesizeOptions& options, const synthesis::SynthesisConfig& config,
                                      const synthesis::TruthSink& truth, const Run& run) {
  const synthesis::DropSource drops = impact_file(options.impacts);
  const bool force = run.common.force;
  if (options.each_drop)
    return synthesis::synthesize_each_drop(drops, config, options.out, force, truth,
                                           progress_line(run, "synthesize", "impacts"));
  return synthesis::synthesize(drops, config, options.out, force, truth,
                               progress_line(run, "synthesize", "s of sound"));
}

}  // namespace

void add_synthesize_options(CLI::App& app, SynthesizeOptions& o) {
  synthesis::SynthesisConfig& c = o.config;
  synthesis::Disturbances& d = c.disturbances;
  const auto not_negative = CLI::NonNegativeNumber;
  app.add_option("--ground", o.ground, "What the ball falls on")->check(CLI::IsMember({"glass", "sic", "vitreloy"}));
  app.add_option("--sensor", o.sensor, "What listens")->check(CLI::IsMember({"piezo", "microphone"}));
  app.add_option("--channel", o.channels,
                 "Position X,Y[,Z[,GAIN]] of a sensor from the plate's middle [m]; once for each of up to 8 channels; "
                 "GAIN 0 is a dead one")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--rate", c.rate_hz, "Sample rate [Hz]")->check(CLI::Range(8000, 2000000));
  app.add_option("--bits", o.bits, "Of a sample")->check(CLI::IsMember({"16", "24", "32", "float"}));
  app.add_option("--snr-db", c.snr_db, "Clean peak of the weakest wanted impact over the rms of the noise [dB]")
      ->check(CLI::Range(-40.0, 200.0));
  app.add_option("--noise-corner", c.noise_corner_hz, "Noise grows like 1/f below this [Hz]; 0: white")
      ->check(not_negative);
  app.add_option("--peak", c.peak, "Clean peak of the strongest impact, full scale = 1; above 1 it is clipped")
      ->check(CLI::Range(1e-6, 1e3));
  app.add_option("--lead-in", c.lead_in_s, "Before the first release [s]")->check(CLI::Range(0.01, 3600.0));
  app.add_option("--pause", c.pause_s, "After each drop's last impact [s]")->check(CLI::Range(0.05, 3600.0));
  app.add_option("--positions", o.positions,
                 "Where the ball strikes: as simulated (where the impacts have states) or drawn, one place a drop")
      ->check(CLI::IsMember({"simulated", "drawn"}));
  app.add_option("--spread", c.start_spread_m, "Drawn positions lie within this of the middle [m]")
      ->check(not_negative);
  app.add_option("--max-mode", c.max_mode_hz, "Modes of the ground up to this [Hz]")->check(CLI::Range(100.0, 200e3));
  app.add_option("--hard", o.hard_case, hard_case_help());
  const char* group = "Disturbances (levels in units of the weakest wanted impact's peak)";
  app.add_option("--hum", d.hum_level, "Mains hum with harmonics")->check(not_negative)->group(group);
  app.add_option("--hum-hz", d.hum_hz, "Mains frequency [Hz]")->check(CLI::Range(1.0, 1000.0))->group(group);
  app.add_option("--drift", d.drift_level, "Slow wander of the zero line")->check(not_negative)->group(group);
  app.add_option("--clicks", d.clicks_per_s, "Electric clicks [1/s]")->check(not_negative)->group(group);
  app.add_option("--knocks", d.knocks_per_s, "Knocks of a second object [1/s]")->check(not_negative)->group(group);
  app.add_option("--double-hits", d.double_hit_fraction, "Share of impacts followed by a knock within 12 ms")
      ->check(CLI::Range(0.0, 1.0))
      ->group(group);
  app.add_flag("--robot", d.robot_cycle, "Release click, fan, motors and pick-up; needs --pause 2 or more")
      ->group(group);
  app.add_option("--timbre-wander", d.timbre_wander, "Standard deviation of ln(mode amplitude) between impacts")
      ->check(CLI::Range(0.0, 3.0))
      ->group(group);
  app.add_option("--phase-wander", d.phase_wander_rad, "Standard deviation of mode phases between impacts [rad]")
      ->check(CLI::Range(0.0, 10.0))
      ->group(group);
}

synthesis::SynthesisConfig synthesis_config(const SynthesizeOptions& options, const CommonOptions& common) {
  synthesis::SynthesisConfig config = options.config;
  config.seed = common.seed;
  config.n_threads = common.n_threads;
  config.ground = synthesis::ground_preset(preset_of(options.ground));
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

Outcome run_synthesize(const SynthesizeOptions& options, Run& run) {
  const synthesis::SynthesisConfig config = synthesis_config(options, run.common);
  const std::filesystem::path out = options.out;
  const std::filesystem::path truth =
      options.truth.empty() ? beside(out, ".truth.csv") : std::filesystem::path(options.truth);
  check_may_write(run, out);
  TruthFiles files(run, truth, options.impacts);
  const synthesis::SynthesisResult result = make_sound(
      options, config, [&files](const synthesis::DropTruth& drop) { files.add(drop); }, run);
  files.finish();

  Outcome outcome;
  outcome.warnings = result.warnings;
  outcome.summary = summary_of(result);
  outcome.text =
      fmt::format("{:.1f} s of sound with {} impacts in {}, truth in {}\n", result.duration_s, result.n_impacts,
                  options.each_drop ? std::to_string(result.n_files) + " files" : out.string(), truth.string());
  return outcome;
}

Command add_synthesize_command(CLI::App& app) {
  auto options = std::make_shared<SynthesizeOptions>();
  CLI::App* command =
      app.add_subcommand("synthesize", "Impact times to sound: plate, sensor, noise; exact times beside it as truth");
  command->footer("Example: bouncelab synthesize impacts.csv --out recording.flac --snr-db 20 --hum 0.5");
  command->add_option("impacts", options->impacts, "Impacts: FILE.csv or FILE.h5")->required();
  command->add_option("--out", options->out, "Sound: .wav (RF64 above 4 GiB), .flac, .w64 or .rf64")->required();
  command->add_option("--truth", options->truth, "True onsets [OUT without its extension + .truth.csv]");
  command->add_flag("--each-drop", options->each_drop, "One file for each drop: NAME.0000.wav, NAME.0001.wav ...");
  add_synthesize_options(*command, *options);
  return {command, [options](Run& run) { return run_synthesize(*options, run); }};
}

}  // namespace bouncelab::cli
