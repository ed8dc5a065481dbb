// SPDX-License-Identifier: GPL-3.0-or-later
/// The stages on files: the options of each, and the function that runs it, as the command line and Python call it.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "bouncelab/fit/fit.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/sim/experiment.hpp"
#include "bouncelab/sim/surface.hpp"
#include "stage_options/options.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

// What is known of the ball in what a stage reads, by the provenance of files or a table in memory (ball_of_files.cpp).

/// How impacts came about, as the options of the stage that made them say it: ball, plate, and of a simulation
/// asperities, drag, gravity.
using World = std::map<std::string, std::string>;

/// What a stage's parameters say of it.
World world_of(const Parameters& parameters);
/// What is the same of all files: only the provenance beside a file is read, not those of its inputs.
/// @param files  at least one. @throws FileError where a provenance cannot be read
World world_of(const std::vector<std::filesystem::path>& files);
/// Puts it among the parameters of what is made in this world.
void keep_world(const World& world, Parameters& parameters);

// The options in this world, where they do not say otherwise.
// @param of  what came about in it, for errors. @throws FileError where the world cannot be
BallChoice in_world(const World& world, BallChoice choice, const std::string& of);
/// Ball and plate; the paper's where none is known.
SynthesizeOptions in_world(const World& world, SynthesizeOptions options, const std::string& of);
/// Ball and plate; of a simulation gravity and whether there was air (contacts take no time in it).
RestitutionOptions in_world(const World& world, RestitutionOptions options, const Given& given, const std::string& of);
/// In the world of files. @throws as in_world; InvalidArgument where the files were made in several
RestitutionOptions with_conditions_of(const std::vector<std::filesystem::path>& files, RestitutionOptions options,
                                      const Given& given);
/// What was understood, as a line.
std::string ball_line(const BallChoice& choice);

// sections_of(): the options of a stage but for the files that it reads and writes.
// prepare(): sets what was not typed.

/// With --preset paper the number of drops and impacts of the paper's run, where the user did not set them.
void prepare(SimulateOptions& options, const Given& given);

/// The asperities of the file that the options name; absent where they name none. @throws FileError
std::optional<sim::Surface> surface_from_file(const SimulateOptions& options, const Ball& ball);

/// The asperities of that file, else those drawn. @throws FileError
sim::Surface surface_of(const SimulateOptions& options, const sim::SimulationConfig& config, const Run& run);

/// The files that a simulation reads: surface, table of the law.
std::vector<std::filesystem::path> simulation_inputs(const SimulateOptions& options);

/// What --json prints.
Object summary_of(const sim::SimulationResult& result, const Ball& ball);

std::vector<Section> sections_of(SimulateOptions& options);
/// Simulates and writes options.out (and options.write_surface where named).
Outcome run_simulate(const SimulateOptions& options, const Run& run);

std::vector<Section> sections_of(SynthesizeOptions& options);
/// Option --codec, which needs files.
Section codec_section(SynthesizeOptions& options, std::vector<std::string> stages = {});

/// What is simulated and made sound of, by one choice of ball and plate.
struct Scene {
  BallChoice world = kPaperBall;  ///< of both stages, in place of their own
  SimulateOptions simulate;
  SynthesizeOptions synthesize;
};
/// Ball, drops, sound and disturbances.
std::vector<Section> scene_sections(Scene& scene, bool with_codec = false);
/// One combination of the values that a configuration file lists: of a scene, or of the seed.
/// @throws InvalidArgument naming the option
void set_scene(Scene& scene, CommonOptions& common, const loop::Settings& settings);

/// Reads options.impacts, writes options.out, the truth, and OUT.others.csv where there are sounds of other things.
Outcome run_synthesize(const SynthesizeOptions& options, const Run& run);

struct DetectOptions {
  std::vector<std::string> recordings;
  std::string list;  ///< file with more recordings, one a line; empty: none
  std::string out;
  std::string labels;
  detection::DetectionConfig config;
};

std::vector<Section> sections_of(DetectOptions& options);

using Recordings = std::vector<detection::RecordingDetection>;

/// The recordings named and those of the list.
/// @throws FileError where the list cannot be read; InvalidArgument where there is no recording
std::vector<std::filesystem::path> recordings_of(const DetectOptions& options);

std::vector<std::filesystem::path> readable_of(const Recordings& recordings);
/// What --json prints. @param warnings  that are not of one recording alone
Object summary_of(const Recordings& recordings, const std::vector<Note>& notes);
/// Text, warnings and what went wrong. @param warnings  of the files
Outcome detection_outcome(const Recordings& recordings, std::vector<Note> notes);

/// Writes options.out and, where named, options.labels; neither where no impact was found. A recording with the same
/// content as one before it counts once, and a warning names both.
Outcome run_detect(const DetectOptions& options, const Run& run);

std::vector<Section> sections_of(RestitutionOptions& options);

/// What --json prints.
Object summary_of(const fit::RestitutionCounts& counts, const fit::RestitutionConfig& config);

/// The samples are in the file only: there may be more than the memory holds.
Outcome run_restitution(const RestitutionOptions& options, const Run& run);

struct FitOptions {
  FitOptions() { config.memory = fit::UseMemory::where_long; }

  std::vector<std::string> samples;  ///< files
  std::string out;
  std::string table;       ///< empty: none
  std::string histograms;  ///< likewise
  std::string slopes;      ///< likewise
  std::string groups;      ///< table of plates; empty: none
  std::string columns;     ///< of a table that this program did not write: "v=speed,eps=e"
  fit::FitConfig config;
  BallChoice world;  ///< in place of what the samples say
};

/// The answer, some of several recordings, what was taken, one doubt: at most twelve lines of a hundred characters.
/// @param taken_for  what tables of other programs were taken for
/// @param constants  a sentence of them, or nothing. @param where  the rest is, the last line
std::string answer_text(const fit::FitResult& result, const report::FitInWords& words,
                        const std::vector<std::string>& taken_for, const std::string& constants,
                        const std::string& where);

std::vector<Section> sections_of(FitOptions& options);
/// What the options describe.
fit::FitConfig fit_config(const FitOptions& options, const CommonOptions& common);

/// What stood on the command line was not taken, it was given.
void leave_out_given(const Given& given, std::vector<report::Taken>& taken);

/// Text and notes; exit code 1 where there is no curve.
/// @param samples  where they are from, for the error
Outcome fit_outcome(const fit::FitResult& result, const report::FitInWords& words, const std::string& samples);
/// What is known is written whatever the exit code.
Outcome run_fit(const FitOptions& options, const Run& run);

struct RoughnessOptions {
  std::vector<std::string> samples;  ///< files
  std::string out;                   ///< empty: none
  std::string columns;               ///< of a table that this program did not write: "v=speed,eps=e"
  fit::RoughnessConfig config;
  BallChoice world;  ///< in place of what the samples say
};

std::vector<Section> sections_of(RoughnessOptions& options);
/// Exit code 1 where the scatter is not that of a rough ball, or there are too few impacts to know.
Outcome run_roughness(const RoughnessOptions& options, const Run& run);

struct AnalyzeOptions {
  std::string out;
  DetectOptions detect;
  RestitutionOptions restitution;  ///< with the ball, which the fit reads in the samples
  FitOptions fit;
  bool diagnostics = false;  ///< details of each drop in the report
};

std::vector<Section> sections_of(AnalyzeOptions& options);
/// What is known of the recordings, as with_conditions_of.
void prepare(AnalyzeOptions& options, const Given& given);
Outcome run_analyze(const AnalyzeOptions& options, const Run& run);

struct CompareOptions {
  std::vector<std::string> samples;  ///< files: samples, or sound
  std::string out;                   ///< folder
  std::string groups;                ///< table of plates and dates; empty: none
  std::string columns;               ///< of a table of samples that this program did not write: "v=speed,eps=e"
  std::string title;                 ///< of the page; empty: of the folder
  RestitutionOptions restitution;    ///< of sound
};

/// With the table of plates.
std::vector<Section> sections_of(CompareOptions& options);
/// Exit code 1 where too few recordings can be compared; what is known of each is written all the same.
Outcome run_compare(const CompareOptions& options, const Run& run);

struct DemOptions {
  std::string fit;
  std::string code = "lammps";
  std::string model;  ///< empty: the first that the fit has for the code
  std::optional<double> youngs_modulus_pa;
};

std::vector<Section> sections_of(DemOptions& options);
/// What the content of options.fit has for the code. Exit code 1 where it has nothing of the kind.
/// @throws FileError where it is no fit.json
Outcome dem_of(const std::string& content, const DemOptions& options);
Outcome run_dem(const DemOptions& options, const Run& run);

struct LoopOptions {
  std::string preset = "quick";
  std::string out;
  Scene scene;
  bool keep_sound = false;      ///< of the paper's run
  bool without_memory = false;  ///< of the paper's run: without the fits with memory
};

/// Runs the loop and writes what it returned; of lists in the configuration file the loop of every combination, through
/// memory, into sweep.csv, sweep.json and report.html. @throws InvalidArgument saying which combination is wrong
Outcome run_loop(const LoopOptions& options, const Run& run);

/// With the folder and the ball.
std::vector<Section> sections_of(LoopOptions& options);
/// The paper's run, where the user did not choose otherwise.
void prepare(LoopOptions& options, const Given& given);

struct ReportOptions {
  std::string folder;  ///< with fit.json and what lies beside it, or the page of a comparison or validation
  std::string out;
  std::string title;      ///< empty: named after the folder
  std::string figures{};  ///< folder for each figure as SVG, PDF and CSV; empty: none
};

/// Its last part: where it lies says nothing to a reader.
std::string name_of_folder(const std::filesystem::path& folder);

Outcome run_report(const ReportOptions& options, const Run& run);

/// Is this a fit.json? Those of 0.2 have no curve.
bool is_fit(const std::string& content);
struct ValidateOptions {
  std::vector<std::string> detectors;   ///< commands, or builtin
  std::vector<std::string> recordings;  ///< files and folders of sound; empty: synthesized
  std::string truth;                    ///< of the recordings a folder, of the marks a file
  std::string marks;                    ///< times that exist already
  std::string out;
  double time_limit_s = 60.0;  ///< for one recording
  bool offset_only = false;
  bool annotated_only = false;  ///< marks before the first and after the last true time do not count
  Scene scene;                  ///< what is synthesized
};
std::vector<Section> sections_of(ValidateOptions& options);

/// Scores detectors against true times: those of synthesized recordings, one for each value of each list of the
/// configuration file beside the first, or of recordings that there are; or marks against truth, file against file.
/// Writes scores.csv, validation.json and, in folders, recordings and marks.
/// @throws InvalidArgument, FileError; what a detector does wrong costs the recording only
Outcome run_validate(const ValidateOptions& options, const Run& run);

}  // namespace bouncelab::stages
