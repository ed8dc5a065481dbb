// SPDX-License-Identifier: GPL-3.0-or-later
#include "loop_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "measured.hpp"

namespace bouncelab::cli {
namespace {

/// {value, se} of an estimate of fit.json; empty where it is not known.
Json estimate(const Json& parent, const char* key, const char* value_name = "value") {
  Json result = Json::object();
  if (!parent.is_object() || !parent.contains(key) || !parent[key].is_object()) return result;
  const Json& found = parent[key];
  if (found.contains("value") && found["value"].is_number()) result[value_name] = found["value"];
  if (found.contains("se") && found["se"].is_number()) result["se"] = found["se"];
  return result;
}

/// {eps, se} at the node of this speed; empty where the fit has none.
Json node_at(const Json& fit, double v_mps) {
  Json result = Json::object();
  if (!fit.contains("law") || !fit["law"].contains("nodes")) return result;
  for (const Json& node : fit["law"]["nodes"]) {
    if (std::abs(node["v_mps"].get<double>() - v_mps) > 1e-9) continue;
    for (const char* key : {"eps", "se"})
      if (node.contains(key) && node[key].is_number()) result[key] = node[key];
  }
  return result;
}

Json histogram_at(const Json& fit, double v_mps) {
  if (fit.contains("histograms"))
    for (const Json& histogram : fit["histograms"])
      if (std::abs(histogram["v_mps"].get<double>() - v_mps) < 1e-9) return histogram;
  return Json::object();
}

Json slopes_at(const Json& fit, double v_mps) {
  const Json histogram = histogram_at(fit, v_mps);
  return {{"rising", estimate(histogram, "slope_rising")}, {"falling", estimate(histogram, "slope_falling")}};
}

std::optional<double> constant_of(const RestitutionLaw& law, std::size_t i) {
  const auto* series = std::get_if<SeriesLaw>(&law);
  if (series == nullptr || i >= series->a.size()) return std::nullopt;
  return series->a[i];
}

std::vector<double> node_speeds(const Json& fit) {
  std::vector<double> speeds;
  if (fit.contains("law") && fit["law"].contains("nodes"))
    for (const Json& node : fit["law"]["nodes"]) speeds.push_back(node["v_mps"].get<double>());
  return speeds;
}

std::string cell(const Json& estimate, const char* value_name = "value") {
  if (!estimate.is_object() || !estimate.contains(value_name)) return "-";
  return measured(estimate[value_name].get<double>(),
                  estimate.contains("se") ? std::optional(estimate["se"].get<double>()) : std::nullopt);
}

/// Pads to a width counted in characters, not bytes ("±" has two).
std::string padded(const std::string& text, std::size_t width) {
  const auto n = static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
  return n < width ? std::string(width - n, ' ') + text : text;
}

std::string row(const std::string& head, const std::vector<std::string>& cells) {
  std::string line = fmt::format("  {:<24}", head);
  for (const std::string& cell : cells) line += padded(cell, 24);
  return line + "\n";
}

}  // namespace

Json loop_summary(const LoopResults& results) {
  Json summary;
  summary["n_drops"] = results.n_drops;
  summary["n_impacts"] = results.score.n_true;
  summary["n_found"] = results.score.n_found;
  summary["n_missed"] = results.score.n_missed;
  summary["n_invented"] = results.score.n_invented;
  if (results.score.rms_s) summary["time_rms_s"] = *results.score.rms_s;
  if (results.score.rms_within_drops_s) summary["time_rms_within_drops_s"] = *results.score.rms_within_drops_s;
  if (results.score.offset_s) summary["time_offset_s"] = *results.score.offset_s;
  if (results.score.pull_sd) summary["time_pull_sd"] = *results.score.pull_sd;
  summary["n_samples"] = results.n_samples;

  summary["eps_nodes"] = Json::array();
  for (const double v : node_speeds(results.fit_sound))
    summary["eps_nodes"].push_back({{"v_mps", v},
                                    {"truth", restitution(results.truth, v)},
                                    {"from_true_times", node_at(results.fit_true, v)},
                                    {"from_sound", node_at(results.fit_sound, v)}});
  summary["constants"] = Json::array();
  for (const std::size_t i : {2, 4, 5}) {
    const std::string name = "A" + std::to_string(i);
    Json constant{{"name", name},
                  {"from_true_times", estimate(results.fit_true["law"], name.c_str())},
                  {"from_sound", estimate(results.fit_sound["law"], name.c_str())}};
    if (const auto truth = constant_of(results.truth, i)) constant["truth"] = *truth;
    summary["constants"].push_back(constant);
  }
  summary["slopes"] = Json::array();
  for (const double v : {0.3, 0.6, 1.0})
    summary["slopes"].push_back({{"v_mps", v},
                                 {"from_true_times", slopes_at(results.fit_true, v)},
                                 {"from_sound", slopes_at(results.fit_sound, v)}});
  summary["truth_curve"] = Json::array();
  if (results.fit_sound["law"].contains("curve") && results.fit_sound["law"]["curve"].is_array())
    for (const Json& point : results.fit_sound["law"]["curve"]) {
      const double v = point["v_mps"].get<double>();
      summary["truth_curve"].push_back({{"v_mps", v}, {"eps", restitution(results.truth, v)}});
    }
  summary["seconds"] = Json::object();
  for (const auto& [stage, seconds] : results.seconds) summary["seconds"][stage] = seconds;
  summary["warnings"] = results.warnings;
  return summary;
}

std::string loop_table(const Json& s) {
  std::string text =
      fmt::format("Impacts: {} simulated, {} found, {} missed, {} invented\n", s["n_impacts"].get<long>(),
                  s["n_found"].get<long>(), s["n_missed"].get<long>(), s["n_invented"].get<long>());
  if (s.contains("time_rms_s"))
    text += fmt::format("Error of t_i: {:.3g} us rms about a constant {:.3g} us; within drops {:.3g} us\n",
                        1e6 * s["time_rms_s"].get<double>(), 1e6 * s["time_offset_s"].get<double>(),
                        1e6 * s["time_rms_within_drops_s"].get<double>());
  if (s.contains("time_pull_sd"))
    text += fmt::format(
        "Error within drops, less what the contact-time law leaves, over the standard error stated: {:.3g} rms\n",
        s["time_pull_sd"].get<double>());
  text += "\n" + row("", {"truth", "from true times", "from sound"});
  for (const Json& n : s["eps_nodes"])
    text += row(fmt::format("eps at {:g} m/s", n["v_mps"].get<double>()),
                {fmt::format("{:.6f}", n["truth"].get<double>()), cell(n["from_true_times"], "eps"),
                 cell(n["from_sound"], "eps")});
  for (const Json& c : s["constants"])
    text +=
        row(c["name"].get<std::string>(), {c.contains("truth") ? fmt::format("{:g}", c["truth"].get<double>()) : "-",
                                           cell(c["from_true_times"]), cell(c["from_sound"])});
  for (const Json& slope : s["slopes"])
    for (const char* side : {"rising", "falling"})
      text += row(fmt::format("{} slope at {:g} m/s", side, slope["v_mps"].get<double>()),
                  {"", cell(slope["from_true_times"][side]), cell(slope["from_sound"][side])});
  text += "\nSeconds:";
  for (const auto& [stage, seconds] : s["seconds"].items())
    text += fmt::format(" {} {:.1f}", stage, seconds.get<double>());
  return text + "\n";
}

}  // namespace bouncelab::cli
