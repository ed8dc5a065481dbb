// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <utility>

#include "arguments.hpp"
#include "arrays.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/fluctuation.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/loop/detector_score.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"
#include "bouncelab/report/page.hpp"
#include "stages/files/sample_files.hpp"
#include "stages/files/table_file.hpp"
#include "stages/run.hpp"

namespace bouncelab::python {
namespace {

/// @param groups  table of plates; empty: none. @return fit.json
std::string fit(const py::dict& columns, const std::string& groups, const Arguments& arguments,
                const py::object& progress) {
  auto [options, run] = parse<stages::FitOptions>(arguments);
  RestitutionSamples samples = samples_of(columns);
  name_ball(samples, stages::ball_of(options.world), stages::plate_of(options.world));
  std::string json;
  python::run(run, progress, [&, &options = options, &run = run] {
    fit::FitConfig config = stages::fit_config(options, run.common);
    std::vector<Note> notes;
    if (!groups.empty()) config.plates = stages::plates_of(samples, groups, notes);
    const fit::FitResult result = fit::fit_all(samples, config, stages::progress_line(run, "fit", "fits"));
    report::FitInWords words = report::in_words(result, samples, config.memory);
    words.notes = stages::joined(notes, words.notes);
    report::order(words.notes);
    stages::leave_out_given(run.given, words.taken);
    json = json_text(report::object_of(result, words), 1) + "\n";
  });
  return json;
}

/// Recording -> plate, of the recordings that have one.
fit::Plates plates(const py::dict& columns, const std::string& groups) {
  std::vector<Note> notes;
  return stages::plates_of(samples_of(columns), groups, notes);
}

/// @return what `bouncelab roughness --json` prints
std::string roughness(const py::dict& columns, const Arguments& arguments, const py::object& progress) {
  auto [options, run] = parse<stages::RoughnessOptions>(arguments);
  RestitutionSamples samples = samples_of(columns);
  name_ball(samples, stages::ball_of(options.world), stages::plate_of(options.world));
  fit::RoughnessConfig config = options.config;
  config.seed = run.common.seed;
  config.n_threads = run.common.n_threads;
  std::string json;
  python::run(run, progress, [&] {
    const fit::RoughnessResult result = fit::measure_roughness(samples, config);
    json = json_text(report::object_of(result, report::notes_of(result, samples)), 1) + "\n";
  });
  return json;
}

/// @param recordings  of each (truth: columns, marks: columns, duration_s, processor_s)
/// @return JSON {all, recordings}: the scores of all and of each
std::string score_detector(const std::vector<std::tuple<py::dict, py::dict, double, double>>& recordings) {
  std::vector<loop::DetectorScore> scores;
  for (const auto& [truth, marks, duration_s, processor_s] : recordings) {
    loop::TrueTimes times = loop::true_times_from_table(table_of(truth, loop::true_time_columns(), "truth"), "truth");
    for (Onset& onset : times.onsets) onset.recording.clear();  // marks have no name
    Onsets onsets = onsets_from_table(table_of(marks, onset_columns(), "marks"), "marks");
    std::stable_sort(onsets.begin(), onsets.end(), [](const Onset& a, const Onset& b) { return a.t_s < b.t_s; });
    scores.push_back(loop::score_detector(times, onsets, duration_s, processor_s));
  }
  return json_text(Object{{"all", value_of(loop::pooled(scores))}, {"recordings", value_of(scores)}}, 2);
}

/// Runs a stage on files. @return {summary, warnings, error, exit_code}
template <class Options>
py::dict outcome_of(Parsed<Options> call, stages::Outcome (*stage)(const Options&, const stages::Run&),
                    const py::object& progress) {
  stages::Outcome outcome;
  python::run(call.run, progress, [&] { outcome = stage(call.options, call.run); });
  py::dict result;
  result["summary"] = json_text(outcome.result, 2);
  result["warnings"] = report::texts_of(outcome.notes, Severity::warning);
  result["error"] = outcome.error;
  result["exit_code"] = outcome.exit_code;
  return result;
}

/// Into the folder that the arguments name.
py::dict loop(const Arguments& arguments, const py::object& progress) {
  return outcome_of(parse<stages::LoopOptions>(arguments), stages::run_loop, progress);
}

py::dict analyze(const std::vector<std::string>& recordings, const std::string& folder, const Arguments& arguments,
                 const py::object& progress) {
  stages::AnalyzeOptions files;
  files.detect.recordings = recordings;
  files.out = folder;
  try {
    return outcome_of(parse(arguments, files), stages::run_analyze, progress);
  } catch (const AmbiguousTable& table) {
    throw InvalidArgument(with_keywords(table, "analyze(path"));
  }
}

py::dict compare(const std::vector<std::string>& samples, const std::string& folder, const Arguments& arguments,
                 const py::object& progress) {
  stages::CompareOptions files;
  files.samples = samples;
  files.out = folder;
  return outcome_of(parse(arguments, files), stages::run_compare, progress);
}

/// @return what `bouncelab dem` prints
std::string dem(const std::string& fit_json, const Arguments& arguments) {
  stages::DemOptions options = parse<stages::DemOptions>(arguments).options;
  options.fit = "fit";  // in messages
  const stages::Outcome outcome = read_in_memory([&] { return stages::dem_of(fit_json, options); });
  if (!outcome.error.empty()) throw InvalidArgument(outcome.error);
  return outcome.text;
}

/// f of each number, in an array of the same shape.
template <class Function>
py::array_t<double> of_each(const py::array_t<double>& numbers, const Function& f) {
  const auto from = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(numbers);
  py::array_t<double> to(std::vector<py::ssize_t>(numbers.shape(), numbers.shape() + numbers.ndim()));
  std::transform(from.data(), from.data() + from.size(), to.mutable_data(), f);
  return to;
}

/// eps(v) of a law as the command line describes it, "series:A2=0.0467,A4=0.1339,A5=-0.2876".
py::array_t<double> restitution_of_law(const std::string& text, const py::array_t<double>& v_mps) {
  const RestitutionLaw law = restitution_law_from_text(text);
  return of_each(v_mps, [&law](double v) { return bouncelab::restitution(law, v); });
}

/// bouncelab::fluctuation_sides of each speed; arrays of one size. @return {below, above}
py::tuple sides_of_fluctuation(double q, const py::array_t<double>& v_mps, const py::array_t<double>& eps,
                               const py::array_t<double>& eps_slope_spm, const py::array_t<double>& path_m2ps2) {
  const auto v = v_mps.unchecked<1>(), e = eps.unchecked<1>(), slope = eps_slope_spm.unchecked<1>(),
             path = path_m2ps2.unchecked<1>();
  if (e.size() != v.size() || slope.size() != v.size() || path.size() != v.size())
    throw InvalidArgument("v, eps, path and eps_slope: as many of each are needed");
  std::vector<double> below, above;
  for (py::ssize_t k = 0; k < v.size(); ++k) {
    const FluctuationSides sides = fluctuation_sides(q, {v(k), e(k), slope(k), 0.0}, path(k));
    below.push_back(sides.below);
    above.push_back(sides.above);
  }
  return py::make_tuple(array_of(std::move(below)), array_of(std::move(above)));
}

/// The scatter about the law (fit::ScatterModel) at these speeds.
/// @return {mean of the lower and of the upper exponential, standard deviation of the normal part, mean minus peak}
py::tuple scatter(double v_ref_mps, const std::vector<double>& log_below, const std::vector<double>& log_above,
                  double normal_ratio, const py::array_t<double>& v_mps) {
  const fit::ScatterModel model{v_ref_mps, log_below, log_above, normal_ratio};
  return py::make_tuple(of_each(v_mps, [&](double v) { return model.below(v); }),
                        of_each(v_mps, [&](double v) { return model.above(v); }),
                        of_each(v_mps, [&](double v) { return model.normal(v); }),
                        of_each(v_mps, [&](double v) { return model.mean_minus_peak(v); }));
}

/// Writes report.html. @param samples  none: empty
void write_report(const std::string& path, const std::string& title, const std::string& fit_json,
                  const std::string& wave_json, const py::dict& columns, bool force) {
  report::ReportInput input;
  input.title = title;
  input.fit_json = fit_json;
  input.wave_json = wave_json;
  if (!columns.empty()) input.samples_json = report::samples_json(samples_of(columns), fit_json);
  stages::write_text(writing(force), path, report::render(input));
}

/// What a picture shows of the samples, where it shows each: at the plate, without the drag and contact time that the
/// fit found. @return JSON; "" where they are too many
std::string shown_samples(const py::dict& columns, const std::string& fit_json) {
  return report::samples_json(samples_of(columns), fit_json);
}

}  // namespace

void bind_fits(py::module_& m) {
  m.def("fit", &fit);
  m.def("plates", &plates);
  m.def("roughness", &roughness);
  m.def("loop", &loop);
  m.def("analyze", &analyze);
  m.def("compare", &compare);
  m.def("dem", &dem);
  m.def("score_detector", &score_detector);
  m.def("restitution_of_law", &restitution_of_law);
  m.def("scatter", &scatter);
  m.def("sides_of_fluctuation", &sides_of_fluctuation);
  m.def("write_report", &write_report);
  m.def("shown_samples", &shown_samples);
}

}  // namespace bouncelab::python
