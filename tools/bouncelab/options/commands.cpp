// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/commands.hpp"

#include <filesystem>
#include <memory>

#include "bouncelab/core/impacts.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "commands/commands.hpp"
#include "stages/stages.hpp"

namespace bouncelab::cli {
namespace {

// headings of --help
constexpr const char *kWhole = "From recording, or simulation, to the answer", *kStages = "Step by step",
                     *kBeside = "Beside them";

constexpr const char* kList = "File with more recordings, one a line";

/// A command of one struct of options: its files, what describes it otherwise, `more`.
/// @param run      from the options and the Run to the Outcome
/// @param prepare  sets what was not typed
template <class Options, class Work>
Command command_of(Command described, Description files, Work run, void (*prepare)(Options&, const Given&) = nullptr,
                   Section (*more)(Options&) = nullptr) {
  const auto options = std::make_shared<Options>();
  described.sections.push_back({"", files, options.get()});
  if constexpr (requires { sections_of(*options); })
    for (Section& section : sections_of(*options)) described.sections.push_back(std::move(section));
  if (more != nullptr) described.sections.push_back(more(*options));
  if (prepare != nullptr) described.prepare = [options, prepare](const Given& given) { prepare(*options, given); };
  described.run = [options, run](Run& call) { return run(*options, call); };
  return described;
}

Section foreign_section(ForeignFileOptions& options) {
  return section_of(options, "Marks and tables of other programs");
}

/// Of several recordings another than that of the first alone, whose report would be in the way.
std::string folder_beside(const std::vector<std::filesystem::path>& recordings) {
  const std::filesystem::path& path = recordings.front();
  if (path == "-") return "standard-input-bouncelab";
  const std::string more = recordings.size() > 1 ? "-and-" + std::to_string(recordings.size() - 1) + "-more" : "";
  return (path.parent_path() / (path.stem().string() + more + "-bouncelab")).string();
}

Command analyze_command() {
  using O = AnalyzeOptions;
  static constexpr Member files[]{
      member<&O::detect, &DetectOptions::recordings>(
          "recordings",
          "Recordings: WAV, FLAC, MP3 ...; m4a, mp4 and others by ffmpeg; .npy, .csv of samples; - = standard input; "
          "or tables of impact times, intervals, heights or speeds, and marks, of any program")
          .positional(),
      member<&O::detect, &DetectOptions::list>("list", kList).looks_like("FILE"),
      member<&O::out>(
          "out",
          "Folder for onsets, samples, fit and report (default: beside the first recording, its name + -bouncelab; "
          "of three NAME-and-2-more-bouncelab)")
          .writes("FOLDER")};
  return command_of<O>(
      {"analyze",
       kWhole,
       "Recordings, or times, heights, speeds -> eps(v) -> constants and a report; nothing has to be set",
       "Example: bouncelab analyze drop.wav --out out/drop\n"
       "         bouncelab analyze times.csv --ball table-tennis\n"
       "         bouncelab analyze heights.csv --as heights --unit m   # 1, .81, .66: release, then each bounce",
       {"detect", "restitution", "fit", "report"}},
      files, run_analyze, +[](O& options, const Given& given) {
        if (options.out.empty()) options.out = folder_beside(recordings_of(options.detect));
        prepare(options, given);
      });
}

Command loop_command() {
  return command_of<LoopOptions>(
      {"loop",
       kWhole,
       "The closed loop: simulate -> synthesize -> detect -> restitution -> fit -> report, all results in one folder",
       "Examples: bouncelab loop --preset quick --out out/loop\n"
       "          bouncelab loop --preset paper --out out/paper\n"
       "          bouncelab loop --config samples/sweep.toml --out out/sweep   (lists in the file are run through)",
       {"simulate", "synthesize", "detect", "restitution", "fit", "report"},
       true},
      {}, run_loop, prepare);
}

Command simulate_command() {
  using O = SimulateOptions;
  static constexpr Member files[]{
      member<&O::out>("out", "Impacts, .csv").writes("FILE").required(),
      member<&O::write_surface>("write_surface", "Write the asperities, .csv").writes("FILE")};
  return command_of<O>({"simulate",
                        kStages,
                        "Drop a rough ball: impact times, velocities, asperities",
                        "Example: bouncelab simulate --drops 10 --asperities 100000 --out impacts.csv",
                        {},
                        false,
                        {{"Columns of the impacts", description_of(columns_of(static_cast<const Impact*>(nullptr)))},
                         {"With --state also, at the instant of contact, z normal to the plate",
                          description_of(columns_of(static_cast<const ImpactState*>(nullptr)))}}},
                       files, run_simulate, prepare);
}

Command synthesize_command() {
  using O = SynthesizeOptions;
  static constexpr Member files[]{
      member<&O::impacts>("impacts", "Impacts: FILE.csv").required().positional(),
      member<&O::out>("out", "Sound: .wav (RF64 above 4 GiB), .flac, .w64 or .rf64").writes("FILE").required(),
      member<&O::truth>("truth", "True onsets (default OUT without its extension + .truth.csv)").writes("FILE"),
      member<&O::each_drop>("each_drop", "One file for each drop: NAME.0000.wav, NAME.0001.wav ...")};
  return command_of<O>(
      {"synthesize",
       kStages,
       "Impact times to sound: plate, sensor, noise; exact times beside it as truth",
       "Example: bouncelab synthesize impacts.csv --out recording.flac --snr-db 20 --hum 0.5",
       {},
       false,
       {{"Columns of the truth, a row for each impact, and `recording`, the file of the sound",
         description_of(columns_of(static_cast<const synthesis::TrueImpact*>(nullptr)))}}},
      files,
      [](O& options, Run& run) {
        keep_world(world_of({std::filesystem::path(options.impacts)}), run.parameters);
        return run_synthesize(options, run);
      },
      +[](O& options, const Given&) {
        options = in_world(world_of({std::filesystem::path(options.impacts)}), options, options.impacts);
      },
      +[](O& options) {
        options.world = {};  // that of the impacts
        return codec_section(options);
      });
}

Command detect_command() {
  static constexpr Member files[]{
      member<&DetectOptions::recordings>(
          "recordings",
          "Recordings: WAV, FLAC, MP3 ...; m4a, mp4 and others by ffmpeg; .npy, .csv of samples; - = standard input")
          .positional(),
      member<&DetectOptions::list>("list", kList).looks_like("FILE"),
      member<&DetectOptions::out>("out", "Onsets, .csv").writes("FILE").required(),
      member<&DetectOptions::labels>("labels", "Also an Audacity label track").writes("FILE")};
  return command_of<DetectOptions>(
      {"detect", kStages, "Impact times of bouncing balls in recordings, with standard errors; nothing has to be set",
       "Example: bouncelab detect drop.wav --out onsets.csv --labels drop.txt"},
      files, [](DetectOptions& options, Run& run) {
        keep_world(world_of(recordings_of(options)), run.parameters);
        return run_detect(options, run);
      });
}

Command restitution_command() {
  using O = RestitutionOptions;
  static constexpr Member files[]{
      member<&O::onsets>(
          "onsets",
          "Onsets, as detect writes them; or marks, or a table of times or intervals from any program. Several files "
          "are taken in this order; rows without a recording are of one that is called like the file")
          .required()
          .positional(),
      member<&O::out>("out", "Samples, .csv").writes("FILE").required()};
  return command_of<O>(
      {"restitution", kStages, "Coefficients of restitution from impact times: ratios of neighbouring intervals",
       "Example: bouncelab restitution onsets.csv --out samples.csv\n"
       "         bouncelab restitution monday.csv tuesday.csv --out samples.csv"},
      files, run_restitution,
      +[](O& options, const Given& given) {
        options = with_conditions_of({options.onsets.begin(), options.onsets.end()}, options, given);
      },
      +[](O& options) { return foreign_section(options.foreign); });
}

Command fit_command() {
  using O = FitOptions;
  static constexpr Member files[]{
      member<&O::samples>(
          "samples",
          "Samples; columns v_mps and eps are enough, or a table of speeds and eps from elsewhere. Recordings, by "
          "the column `recording` or else by the name of "
          "the file, are tested for agreement; where two files have the same drop of the same recording, they are "
          "two recordings")
          .required()
          .positional(),
      member<&O::out>("out", "Results, .json").writes("FILE").required(),
      member<&O::columns>("columns", "Which columns of a table from elsewhere are what (default: by their titles)")
          .looks_like("v=COLUMN,eps=COLUMN"),
      member<&O::table>("table", "Also eps(v) as a table v_mps, eps, lo95, hi95").writes("FILE"),
      member<&O::histograms>("histograms", "Also p(eps) in windows of speed: bins, counts, density with its error, fit")
          .writes("FILE"),
      member<&O::slopes>("slopes",
                         "Also the slopes of p(eps): a row for each window of speed, of all and of each "
                         "recording or plate, with errors")
          .writes("FILE"),
      member<&O::groups>("groups",
                         "Table of columns recording, plate: the recordings of a plate are fitted together, and each "
                         "plate has its own constants, slopes and row")
          .looks_like("FILE")};
  return command_of<O>(
      {"fit", kStages, "eps(v), the constants of its law and the histograms p(eps) from coefficients of restitution",
       "Example: bouncelab fit samples.csv --out fit.json\n"
       "         bouncelab fit ball_a.csv ball_b.csv --out fit.json\n"
       "         bouncelab fit samples.csv --groups plates.csv --slopes slopes.csv --out fit.json"},
      files, run_fit);
}

Command roughness_command() {
  using O = RoughnessOptions;
  static constexpr Member files[]{
      member<&O::samples>(
          "samples", "Samples of one ball, as restitution writes them: 60 impacts or more, drops of 10 successive ones")
          .required()
          .positional(),
      member<&O::out>("out", "Also the results, .json").writes("FILE"),
      member<&O::columns>("columns", "Which columns of a table from elsewhere are what (default: by their titles)")
          .looks_like("v=COLUMN,eps=COLUMN")};
  return command_of<O>(
      {"roughness", kStages,
       "The roughness of a ball from the scatter of its coefficients of restitution: q, and surfaces that scatter so",
       "Example: bouncelab roughness samples.csv\n"
       "         bouncelab roughness shell.csv --ball table-tennis --out roughness.json"},
      files, run_roughness);
}

Command compare_command() {
  using O = CompareOptions;
  static constexpr Member files[]{
      member<&O::samples>("samples",
                          "Samples, as restitution writes them, ordered by recording, or recordings: from 2 on")
          .required()
          .positional(),
      member<&O::out>("out", "Folder for comparison.json, comparison.csv and report.html").writes("FOLDER").required()};
  return command_of<O>(
      {"compare", kStages,
       "Two recordings or plates: do they differ, and by what? Many: ε of all, drift, plates, outliers",
       "Example: bouncelab compare glass.wav wood.wav --out out/plates\n"
       "         bouncelab compare samples.csv --groups plates.csv --out out/campaign"},
      files, run_compare);
}

Command report_command() {
  using O = ReportOptions;
  static constexpr Member files[]{
      member<&O::folder>("folder", "Folder that `loop`, `analyze`, `fit`, `compare` or `validate` wrote to")
          .required()
          .positional(),
      member<&O::out>("out", "HTML file to write; default FOLDER/report.html").writes("FILE"),
      member<&O::title>("title", "Title of the page"),
      member<&O::figures>(
          "figures",
          "Each figure as SVG and PDF, what it shows as CSV, into this folder, in place of the page unless --out names "
          "one; needs Chromium, Chrome or Edge")
          .writes("FOLDER")};
  return command_of<O>({"report", kStages, "fit.json and what lies beside it -> one HTML file with pictures",
                        "Example: bouncelab report out/loop --out report.html\n"
                        "         bouncelab report out/loop --figures figures"},
                       files, run_report);
}

Command dem_command() {
  using O = DemOptions;
  static constexpr Member file[]{
      member<&O::fit>("fit", "fit.json, as fit, analyze and loop write it").required().positional()};
  return command_of<O>(
      {"dem", kStages,
       "Prints a fitted ball as input of a discrete-element code: one impact on a plate, complete, to try and to copy "
       "from; or a function that draws fluctuating coefficients of restitution (docs/dem.md)",
       "Example: bouncelab dem fit.json --code lammps --model viscoelastic > in.ball && lmp -in in.ball -var v 0.3"},
      file, run_dem);
}

Command convert_command() {
  using O = ConvertOptions;
  static constexpr Member files[]{
      member<&O::input>("input", "Onsets, or marks or times of any program").required().positional(),
      member<&O::outputs>("to", "Files to write").writes("FILE").required(),
      member<&O::foreign, &ForeignFileOptions::recording>(
          "recording", "Recording of the marks (Audacity's do not name it); of several in a table, the one to mark"),
      member<&O::foreign, &ForeignFileOptions::renumber>(
          "renumber",
          "Number the impacts of each drop anew: after marks were taken away, or their intervals stay out")};
  return command_of<O>(
      {"convert", kBeside,
       "Onsets to marks that sound editors show, and marks corrected there back to onsets.\n"
       "Written by extension: .csv; .txt (Audacity labels), .svl (Sonic Visualiser), .TextGrid "
       "(Praat), .wav, .rf64 (cue points in a copy of the recording). Labels hold all that is known of an onset "
       "(Audacity's in FILE.txt.onsets.csv beside them), so nothing is lost. A mark that was moved by more than the "
       "format resolves (Audacity 0.5 us; .svl and cues half a sample; .TextGrid 1 ns), or made, counts as it "
       "stands, without standard error, flagged by_hand.",
       "Example: bouncelab convert onsets.csv --to marks.txt\n"
       "         bouncelab convert marks.txt --recording drop.wav --to corrected.csv"},
      files,
      [](O& options, Run& run) {
        keep_world(world_of({std::filesystem::path(options.input)}), run.parameters);
        return run_convert(options, run);
      },
      nullptr, +[](O& options) { return foreign_section(options.foreign); });
}

Command validate_command() {
  return command_of<ValidateOptions>(
      {"validate",
       kBeside,
       "Any onset detector against sound whose times are exactly known: precision, recall, jitter, bound, errors",
       "Examples: bouncelab validate --config samples/validate.toml --detector builtin --detector aubio='aubioonset -i "
       "{wav}' --out out/validate\n"
       "          bouncelab validate --recordings folder --truth folder --detector 'python3 mine.py {wav}' --out "
       "out/mine\n"
       "          bouncelab validate --marks mine.txt --truth truth.csv\n"
       "Of each list in the configuration file the first value holds in all recordings but those of its other values.",
       {"simulate", "synthesize"},
       true},
      {}, run_validate);
}

Command balls_command() {
  return {"balls",
          kBeside,
          "Lists the balls, materials and plates that --ball and --plate know, with their numbers and sources",
          "Example: bouncelab balls --json",
          {},
          false,
          {},
          {},
          {},
          [](Run&) { return run_balls(); }};
}

Command completion_command() {
  static constexpr Member options[]{
      member<&CompletionOptions::shell>("shell", "bash, zsh or fish; words: what their scripts ask for")
          .one_of("bash,zsh,fish,words")
          .required()
          .positional(),
      member<&CompletionOptions::typed>("typed", "Of `words`: what is typed, the word to complete last").positional()};
  return command_of<CompletionOptions>(
      {"completion", kBeside, "A script by which bash, zsh or fish complete bouncelab's words",
       "Examples: bouncelab completion bash > ~/.local/share/bash-completion/completions/bouncelab\n"
       "          bouncelab completion fish > ~/.config/fish/completions/bouncelab.fish\n"
       "          bouncelab completion zsh > DIR/_bouncelab   (DIR in $fpath)"},
      options, run_completion);
}

}  // namespace

std::vector<Command> all_commands() {
  return {analyze_command(),     loop_command(),    simulate_command(),  synthesize_command(), detect_command(),
          restitution_command(), fit_command(),     roughness_command(), compare_command(),    report_command(),
          dem_command(),         convert_command(), validate_command(),  balls_command(),      completion_command()};
}

}  // namespace bouncelab::cli
