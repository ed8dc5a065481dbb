// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/report/page.hpp"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/core.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "words.hpp"

// The assembler puts the files into the program as they are: no generated source, no file to look for at run time.
#ifdef __EMSCRIPTEN__  // its assembler wants the kind of a section, and each object's type and size
#define BOUNCELAB_SECTION(name) ".section .rodata.bouncelab_asset_" #name ",\"\",@\n"
#define BOUNCELAB_SYMBOL(name, size) ".type " name ",@object\n.size " name ", " size "\n.globl " name "\n" name ":\n"
#define BOUNCELAB_END ".section .text,\"\",@\n"
#else
#define BOUNCELAB_SECTION(name) ".section .rodata\n"
#define BOUNCELAB_SYMBOL(name, size) ".global " name "\n" name ":\n"
#define BOUNCELAB_END ".previous\n"
#endif
#define BOUNCELAB_ASSET(name, path)                                                                                    \
  __asm__(BOUNCELAB_SECTION(name) BOUNCELAB_SYMBOL(                                                                    \
      "bouncelab_asset_" #name,                                                                                        \
      "bouncelab_asset_" #name "_end-bouncelab_asset_" #name) ".incbin \"" path                                        \
                                                              "\"\n" BOUNCELAB_SYMBOL("bouncelab_asset_" #name "_end", \
                                                                                      "1") ".byte 0\n" BOUNCELAB_END); \
  extern "C" const char bouncelab_asset_##name[];                                                                      \
  extern "C" const char bouncelab_asset_##name##_end[];
// the page's scripts, in the order in which they build on each other
#define BOUNCELAB_FOR_EACH_SCRIPT(script)                                                                            \
  script(text) script(plot) script(law_figures) script(scatter_figures) script(sound_figures) script(diagnostics)    \
      script(memory) script(reservoir) script(paper) script(sweep) script(compare) script(validation) script(tables) \
          script(ball) script(answer) script(page)
#define BOUNCELAB_SCRIPT(name) BOUNCELAB_ASSET(name, BOUNCELAB_SCRIPTS "/" #name ".js")
#define BOUNCELAB_TEXT(name)               \
  std::string_view(bouncelab_asset_##name, \
                   static_cast<std::size_t>(bouncelab_asset_##name##_end - bouncelab_asset_##name))
#define BOUNCELAB_TEXT_OF_SCRIPT(name) BOUNCELAB_TEXT(name),

BOUNCELAB_ASSET(template, BOUNCELAB_TEMPLATE)
BOUNCELAB_ASSET(style, BOUNCELAB_STYLE)
BOUNCELAB_FOR_EACH_SCRIPT(BOUNCELAB_SCRIPT)
#ifdef __EMSCRIPTEN__  // a file of the page, which puts it into the report (tools/web/src/api.js)
static constexpr std::string_view kPlotly = "@PLOTLY@";
#else
BOUNCELAB_ASSET(plotly, BOUNCELAB_PLOTLY)
static const std::string_view kPlotly = BOUNCELAB_TEXT(plotly);
#endif

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
  for (const char c : data.dump(-1, ' ', false, Json::error_handler_t::replace))  // names need not be UTF-8
    text += c == '<' ? "\\u003c" : std::string(1, c);
  return text;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  return out;
}

std::string all_scripts() {
  std::string script;
  for (const std::string_view part : {BOUNCELAB_FOR_EACH_SCRIPT(BOUNCELAB_TEXT_OF_SCRIPT)}) script += part;
  return script;
}

// What a fit.json says of a ball, as inputs of discrete-element codes: of its numbers alone, so that a text that was
// written into the file goes nowhere.

std::optional<double> number_if_known(const Json& value) {
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

/// ε(v) at its points and nodes.
fit::Curve curve_of(const Json& json) {
  fit::Curve curve;
  for (const Json& point : json.at("points"))
    curve.points.push_back({point.at("v_mps").get<double>(), point.at("eps").get<double>(), {}, {}});
  for (const Json& node : json.at("nodes")) {
    fit::Estimate eps;
    eps.value = node.at("eps").get<double>();
    eps.se = number_if_known(node.at("se"));
    curve.nodes.push_back({node.at("v_mps").get<double>(), eps, {}, {}});
  }
  return curve;
}

/// Whether a fit can have made the curve, and the hand-off speed lies on it.
bool is_possible(const fit::Curve& curve, double v_mps) {
  constexpr double kMost = 1.2;  // of ε, by scatter
  const auto is_eps = [](double eps) { return eps >= 0.0 && eps < kMost; };
  double slowest = HUGE_VAL, fastest = 0.0;
  for (const fit::CurvePoint& point : curve.points) {
    if (!(point.x > fastest) || !is_eps(point.y)) return false;
    slowest = std::min(slowest, point.x), fastest = point.x;
  }
  for (const fit::CurveNode& node : curve.nodes) {
    if (!(node.v_mps > 0.0) || !is_eps(node.eps.value)) return false;
    slowest = std::min(slowest, node.v_mps), fastest = std::max(fastest, node.v_mps);
  }
  return v_mps >= slowest && v_mps <= fastest;
}

std::optional<fit::ScatterModel> scatter_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  fit::ScatterModel scatter{json.at("v_ref_mps").get<double>(), json.at("log_below").get<std::vector<double>>(),
                            json.at("log_above").get<std::vector<double>>(), json.at("normal_ratio").get<double>()};
  if (!(scatter.v_ref_mps > 0.0 && scatter.normal_ratio >= 0.0) || scatter.log_below.empty() ||
      scatter.log_above.empty())
    throw std::logic_error("scatter");
  return scatter;
}

RestitutionLaw law_of(const Json& constants) {
  SeriesLaw series;
  series.a.assign(kViscoelasticC.size(), 0.0);
  for (const Json& parameter : constants.at("parameters")) {
    const std::string name = parameter.get<std::string>();
    const double value = constants.at(name).at("value").get<double>();
    if (name == "gamma") return ViscoelasticLaw{value};
    if (name == "eps") return ConstantLaw{value};
    series.a.at(std::stoul(name.substr(1))) = value;
  }
  return series;
}

}  // namespace

std::optional<fit::DemExport> dem_of_fit(const std::string& fit_json, std::optional<double> youngs_modulus_pa) {
  try {
    const Json fit = Json::parse(fit_json);
    if (!fit.at("hand_off").is_object() || !fit.at("curve").is_object()) return std::nullopt;
    std::optional<fit::DemMemory> memory;
    if (fit.at("constants").at("with_memory").get<bool>()) {
      memory.emplace().law = law_of(fit.at("constants"));
      memory->q = fit.at("roughness").at("q").get<double>();
    }
    const Json &ball = fit.at("budget").at("ball"), &plate = fit.at("budget").at("plate");
    const fit::Curve curve = curve_of(fit.at("curve"));
    const double v_mps = fit.at("hand_off").at("v_mps").get<double>();
    if (!is_possible(curve, v_mps)) throw std::logic_error("curve");
    return fit::dem_export(curve, scatter_of(fit.at("scatter")), v_mps,
                           ball.is_string() ? std::optional(ball_from_text(ball.get<std::string>())) : std::nullopt,
                           plate.is_string() ? std::optional(plate_from_text(plate.get<std::string>())) : std::nullopt,
                           memory, youngs_modulus_pa);
  } catch (const std::logic_error&) {  // of a number in a name that is none
  } catch (const Json::exception&) {
  }
  throw InvalidArgument("the fit was changed by hand or by another version: fit the samples again");
}

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
  const std::pair<const char*, const std::string*> texts[]{{"summary", &input.summary_json},
                                                           {"fit", &input.fit_json},
                                                           {"wave", &input.wave_json},
                                                           {"paper", &input.paper_json},
                                                           {"simulation", &input.fit_simulation_json},
                                                           {"sweep", &input.sweep_json},
                                                           {"diagnostics", &input.diagnostics_json},
                                                           {"comparison", &input.comparison_json},
                                                           {"points", &input.comparison_points_json},
                                                           {"samples", &input.samples_json},
                                                           {"validation", &input.validation_json}};
  for (const auto& [name, text] : texts) data[name] = parsed(*text, name);
  if (const auto dem = data["fit"].is_object() ? dem_of_fit(input.fit_json) : std::nullopt)
    for (const fit::Snippet& snippet : dem->snippets)
      data["dem"].push_back({{"program", snippet.program},
                             {"model", snippet.model},
                             {"parameter", snippet.parameter},
                             {"text", snippet.text}});

  // the template once from left to right: what is put in is never searched again
  const std::map<std::string_view, std::string> parts{{"@TITLE@", escaped(input.title)},
                                                      {"@STYLE@", std::string(BOUNCELAB_TEXT(style))},
                                                      {"@PLOTLY@", std::string(kPlotly)},
                                                      {"@DATA@", embedded(data)},
                                                      {"@SCRIPT@", all_scripts()}};
  std::string html;
  std::string_view rest = BOUNCELAB_TEXT(template);
  for (std::size_t at = 0; (at = rest.find('@')) != std::string_view::npos;) {
    const std::string_view name = rest.substr(at, rest.find('@', at + 1) + 1 - at);
    html.append(rest.substr(0, at)).append(parts.at(name));
    rest.remove_prefix(at + name.size());
  }
  html += rest;
  return html;
}

}  // namespace bouncelab::report
