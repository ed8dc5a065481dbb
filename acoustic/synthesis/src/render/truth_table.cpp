// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/synthesis/synthesize.hpp"

namespace bouncelab::synthesis {

const char* to_string(OtherSoundKind kind) {
  switch (kind) {
    case OtherSoundKind::release:
      return "release";
    case OtherSoundKind::click:
      return "click";
    case OtherSoundKind::knock:
      return "knock";
    case OtherSoundKind::fan:
      return "fan";
    case OtherSoundKind::motor:
      return "motor";
    case OtherSoundKind::pickup:
      return "pickup";
  }
  return "";
}

Onsets onsets_of_truth(const std::vector<TrueImpact>& truth, const std::string& recording) {
  Onsets onsets;
  for (const TrueImpact& impact : truth)
    onsets.push_back({recording, impact.drop, impact.impact, impact.t_s, {}, impact.amplitude, impact.snr_db, {}});
  return onsets;
}

Table truth_table(const std::vector<TrueImpact>& truth, const std::string& recording) {
  const auto reals = [&](const char* name, auto member) {
    std::vector<double> values;
    for (const TrueImpact& impact : truth) values.push_back(impact.*member);
    return Column{name, std::move(values)};
  };
  std::vector<std::int64_t> drop, impact;
  std::vector<std::string> flags;
  for (const TrueImpact& row : truth) {
    drop.push_back(row.drop);
    impact.push_back(row.impact);
    flags.push_back(row.flags.text());
  }
  return {{{"recording", std::vector<std::string>(truth.size(), recording_cell(recording))},
           {"drop", std::move(drop)},
           {"impact", std::move(impact)},
           reals("t_s", &TrueImpact::t_s),
           reals("sigma_t_s", &TrueImpact::sigma_t_s),
           reals("amplitude", &TrueImpact::amplitude),
           reals("snr_db", &TrueImpact::snr_db),
           {"flags", std::move(flags)},
           reals("contact_time_s", &TrueImpact::contact_time_s),
           reals("travel_time_s", &TrueImpact::travel_time_s),
           reals("x_m", &TrueImpact::x_m),
           reals("y_m", &TrueImpact::y_m),
           reals("v_mps", &TrueImpact::v_mps)}};
}

Table others_table(const std::vector<OtherSound>& others) {
  std::vector<std::string> kind;
  std::vector<double> t_s;
  for (const OtherSound& sound : others) {
    kind.push_back(to_string(sound.kind));
    t_s.push_back(sound.t_s);
  }
  return {{{"kind", std::move(kind)}, {"t_s", std::move(t_s)}}};
}

}  // namespace bouncelab::synthesis
