// SPDX-License-Identifier: GPL-3.0-or-later
/// The functions of _core: tables as dicts of arrays, everything else as JSON text. The package makes objects of them.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <tuple>
#include <vector>

#include "arguments.hpp"
#include "bouncelab/core/samples.hpp"

namespace bouncelab::python {

namespace py = pybind11;

// Each throws what the command of the same name throws, and InvalidArgument where it would have no result.
// progress: None, or called as progress(label, done, total, unit).

/// @return {columns, summary, warnings}
py::dict simulate(const Arguments& arguments, const py::object& progress);
/// @return {samples (frames x channels, float32), rate, truth, others, duration_s, warnings}
py::dict synthesize(const py::dict& impacts, const std::string& recording, const Arguments& arguments,
                    const py::object& progress);
/// @return {columns, summary, warnings}
py::dict detect_files(const std::vector<std::string>& recordings, const Arguments& arguments,
                      const py::object& progress);
/// @return the same
py::dict detect_samples(const py::array& samples, double rate_hz, const std::string& recording,
                        const Arguments& arguments, const py::object& progress);
/// @return {columns, summary}
py::dict restitution(const py::dict& onsets, const Arguments& arguments);
/// The onsets of heights in this unit, a list for each drop. @param drops  as people write them: their digits count
py::dict onsets_of_heights(const std::vector<std::vector<std::string>>& drops, const std::string& unit);
/// wave.json of a recording.
std::string wave_of_file(const std::string& recording, int channel, const py::dict& onsets, double rate_hz, int track);
std::string wave_of_samples(const py::array& samples, double rate_hz, const std::string& recording, int channel,
                            const py::dict& onsets);
/// Writes sound with the encoding that `bits` names: 16, 24, 32 or float.
void write_sound(const std::string& path, const py::array& samples, int rate_hz, const std::string& bits, bool force);
/// Writes a table as the command line does. @param kind  impacts, onsets or samples
void write_columns(const std::string& path, const py::dict& columns, const std::string& kind, bool force);
/// Reads one.
py::tuple read_columns(const std::string& path, const std::string& kind, const std::string& as, const std::string& unit,
                       const std::string& columns, const std::string& tier);

/// @throws InvalidArgument naming the row that no sample can be
RestitutionSamples samples_of(const py::dict& columns);

/// @return fit.json
std::string fit(const py::dict& samples, const Arguments& arguments, const py::object& progress);
/// @return what `bouncelab roughness --json` prints
std::string roughness(const py::dict& samples, const Arguments& arguments, const py::object& progress);
/// @return {summary, columns of the experiments or None}
/// @param recordings  of each (truth: columns, marks: columns, duration_s, processor_s)
/// @return JSON {all, recordings}: the scores of all and of each
std::string score_detector(const std::vector<std::tuple<py::dict, py::dict, double, double>>& recordings);
/// Into the folder that the arguments name. @return {summary, warnings, error}
py::dict loop(const Arguments& arguments, const py::object& progress);
/// eps(v) of a law as the command line describes it, "series:A2=0.0467,A4=0.1339,A5=-0.2876".
py::array_t<double> restitution_of_law(const std::string& law, const py::array_t<double>& v_mps);
/// bouncelab::fluctuation_sides of each speed; arrays of one size. @return {below, above}
py::tuple sides_of_fluctuation(double q, const py::array_t<double>& v_mps, const py::array_t<double>& eps,
                               const py::array_t<double>& eps_slope_spm, const py::array_t<double>& path_m2ps2);
/// The scatter about the law (fit::ScatterModel) at these speeds.
/// @return {mean of the lower and of the upper exponential, standard deviation of the normal part, mean minus peak}
py::tuple scatter(double v_ref_mps, const std::vector<double>& log_below, const std::vector<double>& log_above,
                  double normal_ratio, const py::array_t<double>& v_mps);
/// Writes report.html. @param samples  none: empty
void write_report(const std::string& path, const std::string& title, const std::string& fit_json,
                  const std::string& wave_json, const py::dict& samples, bool force);
/// Of outputs that no command writes.
stages::Run writing(bool force);

}  // namespace bouncelab::python
