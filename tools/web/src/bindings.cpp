// SPDX-License-Identifier: GPL-3.0-or-later
// The functions of bouncelab.js (tools/web/README.md). Each returns {result} or {error}, which api.js turns into a
// value or an exception of JavaScript.
#include <emscripten/bind.h>
#include <emscripten/val.h>

#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/core.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/foreign_table.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "page.hpp"
#include "stage_options/options.hpp"

namespace bouncelab::web {
namespace {

using emscripten::val;

/// What a table that does not prove its meaning may be: a question and its answers, each with the options that tell it.
val value_of(const AmbiguousTable& table) {
  val question = val::object(), columns = val::array(), readings = val::array();
  for (const AmbiguousTable::Column& column : table.columns()) {
    val one = val::object();
    one.set("title", column.title);
    one.set("first_cells", column.first_cells);
    columns.call<void>("push", one);
  }
  for (const auto& [meaning, told] : table.readings()) {
    val one = val::object(), options = val::object();
    options.set("as", told.as);
    options.set("unit", told.unit);
    if (!told.columns.empty()) options.set("columns", told.columns);
    one.set("meaning", meaning);
    one.set("options", options);
    readings.call<void>("push", one);
  }
  question.set("text", table.question());
  question.set("columns", columns);
  question.set("readings", readings);
  return question;
}

/// What a browser has to be told of a failure: one line.
template <class Work>
val guarded(Work&& work) {
  val answer = val::object();
  const auto failed = [&](const std::string& message) { answer.set("error", message); };
  try {
    answer.set("result", work());
  } catch (const std::bad_alloc&) {
    failed("out of memory; choose a shorter recording");
  } catch (const std::length_error&) {
    failed("out of memory; choose a shorter recording");
  } catch (const std::filesystem::filesystem_error& error) {
    failed(error.path1().string() + ": " + error.code().message());
  } catch (const AmbiguousTable& error) {
    failed(error.what());
    answer.set("question", value_of(error));
  } catch (const std::exception& error) {
    failed(error.what());
  }
  return answer;
}

/// A copy that JavaScript owns: an array of its own of the numbers' type.
template <class Number>
val array_of(const Number* values, std::size_t n) {
  return val(emscripten::typed_memory_view(n, values)).template call<val>("slice");
}

// Tables as JavaScript has them: an object of arrays, one a column. Numbers are Float64Arrays, NaN where one is not
// known; texts are arrays of strings.

val array_of(const std::vector<std::string>& texts) {
  val list = val::array();
  for (const std::string& text : texts) list.call<void>("push", text);
  return list;
}
val array_of(const std::vector<double>& values) { return array_of(values.data(), values.size()); }
val array_of(const std::vector<std::int64_t>& values) {
  return array_of(std::vector<double>(values.begin(), values.end()));
}

Column column_of(const val& values, const ColumnSpec& spec, const std::string& what) {
  if (spec.type == ColumnType::text) return {spec.name, emscripten::vecFromJSArray<std::string>(values)};
  const auto numbers = emscripten::convertJSArrayToNumberVector<double>(values);
  if (spec.type == ColumnType::real) return {spec.name, numbers};
  std::vector<std::int64_t> integers;
  for (const double number : numbers) {
    const std::optional<std::int64_t> integer = whole_number(number);
    if (!integer)
      throw InvalidArgument(what + ", column " + spec.name + ": " + short_number(number) + " is no integer");
    integers.push_back(*integer);
  }
  return {spec.name, integers};
}

val columns_of(const Table& table) {
  val columns = val::object();
  for (const Column& column : table.columns)
    columns.set(column.name, std::visit([](const auto& values) { return array_of(values); }, column.values));
  return columns;
}

/// @param wanted  columns that are taken, where they are there
/// @throws InvalidArgument where columns have not the same length, or an integer is none
Table table_of(const val& columns, const std::vector<ColumnSpec>& wanted, const std::string& what) {
  Table table;
  std::size_t n = 0;
  for (const ColumnSpec& spec : wanted) {
    const val values = columns[spec.name];
    if (values.isUndefined()) continue;
    const auto length = values["length"].as<std::size_t>();
    if (!table.columns.empty() && length != n) throw InvalidArgument(what + ": columns of different lengths");
    n = length;
    table.columns.push_back(column_of(values, spec, what));
  }
  return table;
}

Sound sound_of(const val& samples, double rate_hz, int n_channels, const std::string& name) {
  return {emscripten::convertJSArrayToNumberVector<float>(samples), rate_hz, n_channels, name, {}, {}, {}};
}

val value_of(const Sound& sound) {
  val value = val::object();
  value.set("rate_hz", sound.rate_hz);
  value.set("n_channels", sound.n_channels);
  value.set("samples", array_of(sound.samples.data(), sound.samples.size()));
  value.set("format", sound.format);
  value.set("lossy_coding", sound.lossy_coding);
  value.set("warnings", array_of(sound.warnings));
  return value;
}

/// The analysis that was made last, of which files may be asked for.
std::optional<Analysis> last;

val shown(Analysis analysis) {
  last = std::move(analysis);
  val value = val::object();
  value.set("summary", json_text(last->summary));
  value.set("fit", last->file("fit.json"));
  value.set("channel", last->found.wave ? last->found.wave->channel : 0);
  value.set("taken_for", last->taken_for);
  value.set("onsets", columns_of(to_table(last->found.onsets)));
  const RestitutionSamples& samples = last->found.restitution.samples;
  value.set("samples", columns_of(to_table(samples)));
  const auto value_if = [](const std::optional<fit::Estimate>& e) {
    return e ? std::optional(e->value) : std::nullopt;
  };
  if (const std::optional<fit::Curve>& curve = last->found.fit.curve)
    value.set(
        "samples_at_plate",
        columns_of(to_table(fit::at_the_plate(samples, value_if(curve->kappa_per_m), value_if(curve->contact_s)))));
  return value;
}

val value_of(const Simulation& made) {
  val value = value_of(made.sound);
  value.set("impacts", columns_of(made.impacts));
  value.set("truth", columns_of(made.truth));
  value.set("law", made.law_json);
  return value;
}

/// What the page may set of coefficients, and what its fields take.
std::string balls_json() {
  const fit::RestitutionConfig config;
  Object limits;
  for (const Member& m : members_of(&config))
    limits.emplace_back(m.name, Object{{"least", m.least}, {"greatest", m.greatest}, {"value", m.get(&config)}});
  Object found = options::catalogue();
  found.emplace_back("limits", std::move(limits));
  return json_text(found);
}

std::string text_of(const val& bytes) {
  const auto content = emscripten::convertJSArrayToNumberVector<unsigned char>(bytes);
  return {content.begin(), content.end()};
}

val detected(const Sound& sound, const std::string& options) {
  const auto found = detect(sound, options);
  val value = val::object();
  value.set("summary", json_text(Object{{"recordings", bouncelab::value_of(found)}}));
  value.set("onsets", columns_of(to_table(found.front().found.onsets)));
  return value;
}

std::string file_of_last(const std::string& name) {
  if (!last) throw InvalidArgument("nothing was analysed");
  return last->file(name);
}

}  // namespace

EMSCRIPTEN_BINDINGS(bouncelab) {
  using emscripten::function;
  using Text = std::string;
  function(
      "bound_version", +[] { return guarded([] { return Text(version()) + " (" + Text(commit()) + ")"; }); });
  function(
      "bound_balls", +[] { return guarded(balls_json); });
  function(
      "bound_readSound", +[](const val& bytes, const Text& name) {
        return guarded([&] { return value_of(read_sound(text_of(bytes), name)); });
      });
  function(
      "bound_detect", +[](const val& samples, double rate_hz, int n_channels, const Text& name, const Text& how) {
        return guarded([&] { return detected(sound_of(samples, rate_hz, n_channels, name), how); });
      });
  function(
      "bound_analyze", +[](const val& samples, double rate_hz, int n_channels, const Text& name, const Text& how) {
        return guarded([&] { return shown(analyze(sound_of(samples, rate_hz, n_channels, name), how)); });
      });
  function(
      "bound_analyzeOnsets",
      +[](const val& onsets, const val& samples, double rate_hz, int n_channels, const Text& name, const Text& how) {
        return guarded([&] {
          return shown(analyze_onsets(onsets_from_table(table_of(onsets, onset_columns(), "marks"), "marks"),
                                      sound_of(samples, rate_hz, n_channels, name), how));
        });
      });
  function(
      "bound_holdsTimes", +[](const val& bytes) { return guarded([&] { return holds_times(text_of(bytes)); }); });
  function(
      "bound_analyzeTimes", +[](const val& bytes, const Text& name, const Text& how) {
        return guarded([&] { return shown(analyze_times(text_of(bytes), name, how)); });
      });
  function(
      "bound_file", +[](const Text& name) { return guarded([&] { return file_of_last(name); }); });
  function(
      "bound_simulate", +[](const Text& how) { return guarded([&] { return value_of(simulate(how)); }); });
  function(
      "bound_scatter", +[](const Text& how) { return guarded([&] { return scatter(how); }); });
}

}  // namespace bouncelab::web
