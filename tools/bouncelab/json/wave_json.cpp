// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/wave_json.hpp"

#include <cmath>
#include <cstdint>
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

/// A WAV file, 16 bit, one channel.
std::string wav_file(const detection::ListeningCopy& copy) {
  std::string bytes;
  const auto put = [&](std::uint32_t value, int n_bytes) {
    for (int k = 0; k < n_bytes; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFFU);
  };
  const auto n_bytes = static_cast<std::uint32_t>(2 * copy.samples.size());
  const auto rate_hz = static_cast<std::uint32_t>(std::llround(copy.rate_hz));
  bytes += "RIFF";
  put(36 + n_bytes, 4);
  bytes += "WAVEfmt ";
  put(16, 4);
  put(1, 2);  // PCM
  put(1, 2);  // one channel
  put(rate_hz, 4);
  put(2 * rate_hz, 4);
  put(2, 2);
  put(16, 2);
  bytes += "data";
  put(n_bytes, 4);
  for (const std::int16_t x : copy.samples) put(static_cast<std::uint16_t>(x), 2);
  return bytes;
}

/// RFC 4648, section 4.
std::string base64(const std::string& bytes) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const auto byte = [&](std::size_t j) {
      return j < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[j])) : 0U;
    };
    const std::uint32_t three = byte(k) << 16U | byte(k + 1) << 8U | byte(k + 2);
    for (std::size_t j = 0; j < 4; ++j) text += k + j > bytes.size() ? '=' : kDigits[three >> (18U - 6U * j) & 63U];
  }
  return text;
}

Json to_json(const detection::ListeningCopy& copy) {
  if (copy.samples.empty()) return nullptr;
  return {{"t0_s", copy.t0_s},
          {"duration_s", static_cast<double>(copy.samples.size()) / copy.rate_hz},
          {"wav_base64", base64(wav_file(copy))}};
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
  wave["sound"] = to_json(preview.copy);
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
