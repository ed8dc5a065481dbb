// SPDX-License-Identifier: GPL-3.0-or-later
#include "json/scatter_json.hpp"

namespace bouncelab::cli {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

nlohmann::ordered_json scatter_json(const loop::ScatterTheory& theory) {
  Json slopes = Json::array();
  for (const loop::ExpectedSlopes& s : theory.slopes)
    slopes.push_back({{"v_mps", s.v_mps}, {"n", s.n}, {"rising", s.rising}, {"falling", s.falling}});
  Json densities = Json::array();
  for (const loop::ExpectedDensity& d : theory.densities)
    densities.push_back({{"v_mps", d.v_mps},
                         {"eps", d.eps},
                         {"density", d.density},
                         {"n_simulated", d.n_simulated},
                         {"simulated_counts", d.simulated_counts}});
  return {{"q", theory.q},
          {"contact_factor", theory.contact_factor},
          {"offset_variance", theory.offset_variance},
          {"slopes", slopes},
          {"densities", densities},
          {"n_transforms", theory.n_transforms},
          {"transform_counts", theory.transform_counts}};
}

}  // namespace bouncelab::cli
