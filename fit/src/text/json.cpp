// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/json.hpp"

#include "text/json_parts.hpp"

namespace bouncelab::fit {

Json json_of(const DemExport& h) {
  Json snippets = Json::array();
  for (const Snippet& s : h.snippets)
    snippets.push_back({{"program", s.program}, {"parameter", s.parameter}, {"text", s.text}});
  return {{"v_mps", h.v_mps},
          {"eps", json_of(h.eps)},
          {"se", json_of(h.se)},
          {"warning", h.warning},
          {"snippets", snippets}};
}

Json json_of(const RecordingsTest& t) {
  return {{"n_recordings", t.n_recordings},
          {"likelihood_ratio", json_of(t.likelihood_ratio)},
          {"f", json_of(t.f)},
          {"ndf", json_of(t.ndf)},
          {"ndf_within", json_of(t.ndf_within)},
          {"within", to_string(t.within)},
          {"p_value", json_of(t.p_value)}};
}

Json json_of(const RecordingFit& r) {
  Json j{{"recording", r.recording},
         {"status", to_string(r.status)},
         {"message", r.message},
         {"law", to_string(r.kind)},
         {"n", r.n},
         {"n_outliers", r.n_outliers},
         {"n_drops", r.n_drops},
         {"v_lo_mps", r.v_lo_mps},
         {"v_hi_mps", r.v_hi_mps},
         {"offset", json_of(r.offset)},
         {"nodes", nodes_of(r.nodes)}};
  Json names = Json::array();
  for (const NamedEstimate& p : r.parameters) {
    j[p.name] = json_of(p.estimate);
    names.push_back(p.name);
  }
  j["parameters"] = names;
  return j;
}

Json json_of(const SpeedAndRestitution& at) {
  return {{"v_mps", at.v_mps},
          {"eps", json_of(at.eps.value)},
          {"se", json_of(at.eps.se)},
          {"ci95", json_of(at.eps.ci95)},
          {"energy_lost", json_of(at.energy_lost)}};
}

Json json_of(const DropsSeen& seen) {
  return {{"n_drops", seen.n_drops},
          {"n_impacts", json_of(seen.n_impacts)},
          {"duration_s", json_of(seen.duration_s)},
          {"drop_height_m", json_of(seen.drop_height_m)},
          {"n_heights", seen.n_heights}};
}

Json json_of(const PlainAnswer& answer) {
  Json elsewhere = Json::array(), recordings = Json::array();
  for (const SpeedAndRestitution& at : answer.elsewhere) elsewhere.push_back(json_of(at));
  for (const RecordingAnswer& r : answer.recordings)
    recordings.push_back(
        {{"recording", r.recording}, {"at", json_of(r.at)}, {"missing", r.missing}, {"seen", json_of(r.seen)}});
  return {{"sentences", answer.sentences}, {"at", json_of(answer.at)},          {"elsewhere", elsewhere},
          {"one_value", answer.one_value}, {"with_memory", answer.with_memory}, {"seen", json_of(answer.seen)},
          {"recordings", recordings}};
}

std::string to_json(const FitResult& result, int indent) {
  Json histograms = Json::array();
  for (const HistogramFit& h : result.histograms) histograms.push_back(json_of(h));
  Json recordings = Json::array();
  for (const RecordingFit& r : result.recordings.rows) recordings.push_back(json_of(r));
  Json answers = Json::array();
  for (const Finding& a : result.findings) answers.push_back({{"question", a.question}, {"answer", a.answer}});
  Json j{{"status", to_string(result.status)},
         {"answer", json_of(result.answer)},
         {"warnings", result.warnings},
         {"answers", answers},
         {"n_used", result.n_used},
         {"n_left_out", result.n_left_out},
         {"law", json_of(result.law)},
         {"recordings_test", json_of(result.recordings.test)},
         {"recordings", recordings},
         {"law_least_squares", json_of(result.law_least_squares)},
         {"law_least_absolute", json_of(result.law_least_absolute)},
         {"law_comparison", comparison_of(result.law.comparison)},
         {"law_viscoelastic", json_of(result.law_viscoelastic)},
         {"histograms", histograms},
         {"budget", json_of(result.budget)},
         {"hand_off", json_of(result.dem_export)},
         {"density",
          {{"v_edges_mps", result.density.v_edges_mps},
           {"eps_edges", result.density.eps_edges},
           {"counts", result.density.counts},
           {"n_outside", result.density.n_outside}}}};
  if (const std::optional<MemoryFit>& memory = result.memory) {
    j["memory"] = json_of(*memory);
    j["roughness"] = memory->status == FitStatus::ok ? roughness_of(*memory) : Json(nullptr);
  }
  return j.dump(indent) + "\n";
}

std::string to_json(const RoughnessResult& result, int indent) {
  const MemoryFit& m = result.memory;
  Json j{{"status", to_string(m.status)},
         {"message", m.message},
         {"holds", m.holds},
         {"warnings", result.warnings},
         {"n", m.n},
         {"n_drops", m.n_drops},
         {"n_chains", m.n_chains},
         {"n_left_out", result.n_left_out}};
  const bool fitted = m.status == FitStatus::ok;
  j["roughness"] = fitted ? roughness_of(m) : Json(nullptr);
  j["tests"] = fitted ? tests_of(m) : Json(nullptr);
  j["anderson_darling"] = json_of(m.anderson_darling);
  return j.dump(indent) + "\n";
}

}  // namespace bouncelab::fit
