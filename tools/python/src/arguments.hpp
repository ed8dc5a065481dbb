// SPDX-License-Identifier: GPL-3.0-or-later
/// Options of the command line as keywords of Python: the same names, ranges, units and messages.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/samples.hpp"
#include "stages/stages.hpp"

namespace bouncelab::python {

namespace py = pybind11;

/// Options as the command line has them: "--drops=8", "--drag".
using Arguments = std::vector<std::string>;

template <class Options>
struct Parsed {
  Options options;
  stages::Run run;
};

/// What a function takes. @param files  names those that the stage reads and writes
/// @param prepare  sets what no argument says; as stages::prepare where there is one
/// @throws InvalidArgument as the command line says it
template <class Options>
Parsed<Options> parse(const Arguments& arguments, Options files = {},
                      const std::type_identity_t<std::function<void(Options&, const stages::Given&)>>& prepare = {});

/// The options of a function, in the order of --help: a JSON array of {name, help, type, default, flag, least and most
/// number of values, choices}. @throws InvalidArgument where there is no such function
std::string options_json(const std::string& function);

/// Runs work() without the interpreter's lock, with the threads that the call asks for.
/// @param call      gets a callback for its progress
/// @param progress  called as progress(label, done, total, unit), at most every 50 ms, from one thread at a time, and
///                  at the end with done = total; None: not called. What it throws ends the work
/// @throws py::error_already_set what the handler of a signal raised, KeyboardInterrupt after Ctrl-C, where this is the
///         main thread; what work throws
void run(stages::Run& call, const py::object& progress, const std::function<void()>& work);

// Functions of _core: tables as dicts of arrays, everything else as JSON text. The package makes objects of them. Each
// throws what the command of the same name throws, and InvalidArgument where it would have no result.
// progress: None, or called as progress(label, done, total, unit).

/// Simulation, sound, impact times, coefficients, and tables in files.
void bind_stages(py::module_& m);
/// Fits, scores, laws.
void bind_fits(py::module_& m);

/// What the program says, with the keywords of Python in place of options: "(--min-impacts takes shorter drops)" is
/// "(min_impacts= takes shorter drops)", "--unit cm" "unit='cm'", "--pool" "pool=True", "--nodes: 'x'" "nodes: 'x'".
std::string with_keywords(const std::string& text);
/// The question, and each answer as the call that reads the table so. @param call  its beginning: "analyze(path"
std::string with_keywords(const AmbiguousTable& table, const std::string& call);

/// Tables in memory are no files: what is wrong with them is an argument's fault.
template <class Read>
auto read_in_memory(const Read& read) {
  try {
    return read();
  } catch (const FileError& error) {
    throw InvalidArgument(error.what());
  }
}

/// @throws InvalidArgument naming the row that no sample can be
RestitutionSamples samples_of(const py::dict& columns);
/// Of outputs that no command writes.
stages::Run writing(bool force);

}  // namespace bouncelab::python
