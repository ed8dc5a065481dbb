// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/wave_json.hpp"

#include <nlohmann/json.hpp>

#include "bouncelab/core/input_file.hpp"
#include "json/json_text.hpp"

namespace bouncelab::cli {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const detection::WaveExcerpt& excerpt) {
  Json marks = Json::array();
  for (const detection::WaveExcerpt::Mark& mark : excerpt.marks)
    marks.push_back({{"t_s", mark.t_s},
                     {"sigma_t_s", mark.sigma_t_s ? Json(*mark.sigma_t_s) : Json(nullptr)},
                     {"impact", mark.impact}});
  return {{"title", excerpt.title},
          {"t0_s", excerpt.t0_s},
          {"dt_s", excerpt.dt_s},
          {"samples", excerpt.samples},
          {"marks", marks}};
}

Json to_json(const detection::WavePreview& preview) {
  Json wave{{"recording", preview.recording},
            {"rate_hz", preview.rate_hz},
            {"channel", preview.channel},
            {"duration_s", preview.duration_s},
            {"envelope", {{"t_s", preview.column_t_s}, {"lo", preview.lo}, {"hi", preview.hi}}}};
  wave["marks"] = Json::array();
  for (const Onset& mark : preview.marks)
    wave["marks"].push_back(
        {{"t_s", mark.t_s}, {"drop", mark.drop}, {"impact", mark.impact}, {"flags", mark.flags.text()}});
  wave["excerpts"] = Json::array();
  for (const detection::WaveExcerpt& excerpt : preview.excerpts) wave["excerpts"].push_back(to_json(excerpt));
  return wave;
}

Json to_json(const detection::LearnedWave& wave) {
  return {{"t0_s", wave.t0_s},
          {"dt_s", wave.dt_s},
          {"mean", wave.mean},
          {"spread", wave.spread},
          {"n_impacts", wave.n_impacts}};
}

Json to_json(const std::vector<fit::IntervalPrediction>& predictions) {
  const auto known = [](const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); };
  Json intervals{
      {"impact", Json::array()}, {"found_s", Json::array()}, {"expected_s", Json::array()}, {"sigma_s", Json::array()}};
  for (const fit::IntervalPrediction& p : predictions) {
    intervals["impact"].push_back(p.impact);
    intervals["found_s"].push_back(p.measured_s);
    intervals["expected_s"].push_back(known(p.predicted_s));
    intervals["sigma_s"].push_back(known(p.sigma_s));
  }
  return intervals;
}

Json to_json(const RecordingDetails& details) {
  Json json{{"recording", input_name(details.recording)}, {"n_drops", details.n_drops}, {"drops", Json::array()}};
  if (details.wave) json["wave"] = to_json(*details.wave);
  if (details.noise) json["noise"] = {{"frequency_hz", details.noise->frequency_hz}, {"psd", details.noise->psd}};
  for (const DropDetails& drop : details.drops) {
    Json shown = to_json(drop.preview);
    shown["intervals"] = to_json(drop.intervals);
    json["drops"].push_back(std::move(shown));
  }
  return json;
}

}  // namespace

std::string wave_json(const detection::WavePreview& preview) { return json_text(to_json(preview)); }

std::string diagnostics_json(const std::vector<RecordingDetails>& recordings) {
  Json all = Json::array();
  for (const RecordingDetails& details : recordings) all.push_back(to_json(details));
  return json_text(Json{{"recordings", std::move(all)}});
}

std::string samples_json(const RestitutionSamples& samples) {
  Json json{{"v_mps", Json::array()}, {"eps", Json::array()}, {"sigma_eps", Json::array()}};
  for (const RestitutionSample& sample : samples) {
    json["v_mps"].push_back(sample.v_mps);
    json["eps"].push_back(sample.eps);
    json["sigma_eps"].push_back(sample.sigma_eps ? Json(*sample.sigma_eps) : Json(nullptr));
  }
  return json_text(json);
}

}  // namespace bouncelab::cli
