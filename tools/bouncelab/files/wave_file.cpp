// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/wave_file.hpp"

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/detection/wave_preview.hpp"
#include "files/table_file.hpp"

namespace bouncelab::cli {
namespace {

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

constexpr std::int64_t kDropsShown = 30;

Json to_json(const detection::LearnedWave& wave) {
  return {{"t0_s", wave.t0_s},
          {"dt_s", wave.dt_s},
          {"mean", wave.mean},
          {"spread", wave.spread},
          {"n_impacts", wave.n_impacts}};
}

/// T_{k+1} = eps T_k with T_k = 2 v / g: found with the eps of the sample, expected with that of the law.
Json intervals_of(const RestitutionSamples& samples, const std::string& recording, std::int64_t drop,
                  const std::optional<RestitutionLaw>& law, double gravity_mps2) {
  Json intervals{
      {"impact", Json::array()}, {"found_s", Json::array()}, {"expected_s", Json::array()}, {"sigma_s", Json::array()}};
  for (const RestitutionSample& s : samples) {
    if (s.recording != recording || s.drop != drop) continue;
    const double before_s = 2.0 * s.v_mps / gravity_mps2;
    intervals["impact"].push_back(s.impact);
    intervals["found_s"].push_back(s.eps * before_s);
    intervals["expected_s"].push_back(law ? Json(restitution(*law, s.v_mps) * before_s) : Json(nullptr));
    intervals["sigma_s"].push_back(s.sigma_eps ? Json(*s.sigma_eps * before_s) : Json(nullptr));
  }
  return intervals;
}

}  // namespace

void write_wave(const Run& run, const std::filesystem::path& recording, int channel, const Onsets& onsets,
                const std::filesystem::path& out) {
  write_text(run, out, to_json(detection::wave_preview(recording, channel, onsets)).dump() + "\n", {recording});
}

void write_diagnostics(const Run& run, const std::vector<std::string>& recordings,
                       const std::vector<detection::Detection>& found, const RestitutionSamples& samples,
                       const std::optional<RestitutionLaw>& law, double gravity_mps2,
                       const std::filesystem::path& out) {
  Json all = Json::array();
  std::int64_t n_shown = 0;
  std::vector<std::filesystem::path> shown_recordings;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const detection::Detection& d = found[k];
    if (d.onsets.empty() || n_shown >= kDropsShown) continue;
    shown_recordings.emplace_back(recordings[k]);
    Json one{{"recording", recordings[k]}, {"n_drops", d.summary.n_drops}, {"drops", Json::array()}};
    if (d.wave) one["wave"] = to_json(*d.wave);
    if (d.noise) one["noise"] = {{"frequency_hz", d.noise->frequency_hz}, {"psd", d.noise->psd}};
    audio::AudioReader reader(recordings[k]);
    const audio::AudioSource sound = reader.source(d.summary.channel);
    for (std::int64_t drop = 0; drop < d.summary.n_drops && n_shown < kDropsShown; ++drop, ++n_shown) {
      Json shown = to_json(detection::drop_preview(sound, recordings[k], d.summary.channel, d.onsets, drop));
      shown["intervals"] = intervals_of(samples, recordings[k], drop, law, gravity_mps2);
      one["drops"].push_back(std::move(shown));
    }
    all.push_back(std::move(one));
  }
  write_text(run, out, Json{{"recordings", std::move(all)}}.dump() + "\n", shown_recordings);
}

}  // namespace bouncelab::cli
