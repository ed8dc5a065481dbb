// SPDX-License-Identifier: GPL-3.0-or-later
#include "wave_file.hpp"

#include "bouncelab/acoustic/wave_preview.hpp"
#include "table_file.hpp"

namespace bouncelab::cli {
namespace {

Json to_json(const WaveExcerpt& excerpt) {
  Json marks = Json::array();
  for (const WaveExcerpt::Mark& mark : excerpt.marks)
    marks.push_back({{"t_s", mark.t_s},
                     {"sigma_t_s", mark.sigma_t_s ? Json(*mark.sigma_t_s) : Json(nullptr)},
                     {"impact", mark.impact}});
  return {{"title", excerpt.title},
          {"t0_s", excerpt.t0_s},
          {"dt_s", excerpt.dt_s},
          {"samples", excerpt.samples},
          {"marks", marks}};
}

}  // namespace

void write_wave(const Run& run, const std::filesystem::path& recording, int channel, const Onsets& onsets,
                const std::filesystem::path& out) {
  const WavePreview preview = wave_preview(recording, channel, onsets);
  Json wave{{"recording", preview.recording},
            {"rate_hz", preview.rate_hz},
            {"channel", preview.channel},
            {"duration_s", preview.duration_s},
            {"envelope", {{"t_s", preview.column_t_s}, {"lo", preview.lo}, {"hi", preview.hi}}}};
  wave["marks"] = Json::array();
  for (const Onset& mark : preview.marks)
    wave["marks"].push_back({{"t_s", mark.t_s}, {"drop", mark.drop}, {"impact", mark.impact}, {"flags", mark.flags}});
  wave["excerpts"] = Json::array();
  for (const WaveExcerpt& excerpt : preview.excerpts) wave["excerpts"].push_back(to_json(excerpt));
  write_text(run, out, wave.dump() + "\n", {recording});
}

}  // namespace bouncelab::cli
