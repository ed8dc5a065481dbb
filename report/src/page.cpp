// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/page.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "assets.hpp"
#include "bouncelab/core/core.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "words.hpp"

namespace bouncelab::report {
namespace {

using Json = nlohmann::ordered_json;

Json parsed(const std::string& text, const char* what) {
  if (text.empty()) return nullptr;
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw InvalidArgument(std::string(what) + " is not JSON: " + error.what());
  }
}

/// JSON inside a <script> element: "</script" would end it, "<!--<script" would swallow what follows. A '<' stands in
/// texts only.
std::string embedded(const Json& data) {
  std::string text;
  for (const char c : data.dump(-1, ' ', false, Json::error_handler_t::replace)) {  // names need not be UTF-8
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string samples_json(RestitutionSamples samples, const std::string& fit_json) {
  if (samples.size() > fit::kMostShown) return {};
  const Json fit = parsed(fit_json, "fit.json");
  const auto number = [&](const std::string& place) -> std::optional<double> {
    const Json::json_pointer value("/curve/" + place);
    return fit.contains(value) && fit.at(value).is_number() ? std::optional(fit.at(value).get<double>()) : std::nullopt;
  };
  const auto found = [&](const std::string& key) { return number(key + "/value"); };
  const double errors = number("errors_over_digits").value_or(1.0);
  if (fit.is_object() && fit.contains("curve") && !fit["curve"].is_null())
    samples = fit::at_the_plate(std::move(samples), found("kappa_per_m"), found("contact_s"));
  Values v_mps, eps, sigma_eps;
  for (const RestitutionSample& sample : samples) {
    v_mps.emplace_back(sample.v_mps);
    eps.emplace_back(sample.eps);
    sigma_eps.emplace_back(sample.sigma_eps ? Value(errors * *sample.sigma_eps) : Value());
  }
  return json_text(Object{{"v_mps", v_mps},
                          {"eps", eps},
                          {"sigma_eps", sigma_eps},
                          {"measured", samples.empty() ? "" : measured_in_words(samples.front().conditions)}});
}

std::string render(const ReportInput& input) {
  Json data;
  data["title"] = input.title;
  data["program"] = "bouncelab " + std::string(version()) + ", commit " + std::string(commit());
  data["summary"] = parsed(input.summary_json, "summary.json");
  data["fit"] = parsed(input.fit_json, "fit.json");
  if (const auto dem = data["fit"].is_object() ? dem_of_fit(input.fit_json) : std::nullopt)
    for (const fit::Snippet& snippet : dem->snippets)
      data["dem"].push_back({{"program", snippet.program},
                             {"model", snippet.model},
                             {"parameter", snippet.parameter},
                             {"text", snippet.text}});
  data["wave"] = parsed(input.wave_json, "wave.json");
  data["paper"] = parsed(input.paper_json, "paper.json");
  data["simulation"] = parsed(input.fit_simulation_json, "fit_from_simulation.json");
  data["sweep"] = parsed(input.sweep_json, "sweep.json");
  data["diagnostics"] = parsed(input.diagnostics_json, "diagnostics.json");
  data["comparison"] = parsed(input.comparison_json, "comparison.json");
  data["points"] = parsed(input.comparison_points_json, "the points of the comparison");
  data["samples"] = parsed(input.samples_json, "the samples");
  data["validation"] = parsed(input.validation_json, "validation.json");

  const std::array<std::pair<std::string_view, std::string>, 5> parts{{{"@TITLE@", escaped(input.title)},
                                                                       {"@STYLE@", std::string(asset_style())},
                                                                       {"@PLOTLY@", std::string(asset_plotly())},
                                                                       {"@DATA@", embedded(data)},
                                                                       {"@SCRIPT@", asset_script()}}};
  // the template once from left to right: what is put in is never searched again
  std::string html;
  std::string_view rest = asset_template();
  while (!rest.empty()) {
    std::size_t nearest = rest.size();
    const std::pair<std::string_view, std::string>* part = nullptr;
    for (const auto& candidate : parts) {
      const std::size_t at = rest.find(candidate.first);
      if (at < nearest) {
        nearest = at;
        part = &candidate;
      }
    }
    html += rest.substr(0, nearest);
    if (part == nullptr) break;
    html += part->second;
    rest.remove_prefix(nearest + part->first.size());
  }
  return html;
}

}  // namespace bouncelab::report
