// SPDX-License-Identifier: GPL-3.0-or-later
#include "page.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/loop/theory.hpp"
#include "bouncelab/sim/sim.hpp"
#include "bouncelab/synthesis/synthetic_recording.hpp"
#include "stage_options/options.hpp"

namespace bouncelab::web {
namespace {

/// Options of `simulate` and `synthesize`.
struct SimulateCall {
  options::SimulateOptions simulated;
  options::SynthesizeOptions synthesized;
  Seed seed;

  explicit SimulateCall(const std::string& options_json) {
    set_options({ball_section(simulated.world), options::section_of(simulated), options::section_of(synthesized),
                 disturbances_section(synthesized), options::section_of(seed)},
                options_json);
    synthesized.world = simulated.world;
  }
  sim::SimulationConfig simulation() const { return simulation_config(simulated, seed.seed, 1); }
  sim::Surface surface(const sim::SimulationConfig& config) const {
    return sim::make_surface(config.ball, simulated.n_asperities, sim::radius_law_from_text(simulated.radius_law),
                             seed.seed);
  }
};

/// The simulated law as text and as points up to the speed of the first impact.
std::string law_json(const sim::SimulationConfig& config) {
  constexpr int kPoints = 100;
  const double fastest_mps = std::sqrt(2.0 * config.gravity_mps2 * config.drop_height_max_m);
  Values curve;
  for (int k = 1; k <= kPoints; ++k) {
    const double v_mps = fastest_mps * k / kPoints;
    curve.push_back(Object{{"v_mps", v_mps}, {"eps", restitution(config.law, v_mps)}});
  }
  return json_text(Object{{"law", describe(config.law)}, {"curve", curve}});
}

/// Above this share of contacts with the smooth sphere between the asperities the offsets are far from normal, which
/// the closed form takes them to be.
constexpr double kMostSmooth = 0.1;

/// The windows of speed in which the fit draws p(eps), without bins.
std::vector<fit::HistogramFit> windows_of_fit() {
  const fit::HistogramConfig config;
  std::vector<fit::HistogramFit> windows;
  for (const double v_mps : config.centres_mps) {
    fit::HistogramFit& window = windows.emplace_back();
    window.v_mps = v_mps;
    window.v_lo_mps = v_mps - 0.5 * config.width_mps;
    window.v_hi_mps = v_mps + 0.5 * config.width_mps;
  }
  return windows;
}

/// Bins from five mean distances below eps(v) to five above, by the closed form: all but exp(-5) of either side.
std::vector<fit::HistogramFit> with_bins(std::vector<fit::HistogramFit> windows, const RestitutionLaw& law,
                                         const std::vector<loop::ExpectedSlopes>& slopes) {
  constexpr std::size_t kBins = 32;
  constexpr double kDistances = 5.0;
  std::vector<fit::HistogramFit> used;
  for (fit::HistogramFit& window : windows) {
    const auto found = std::find_if(slopes.begin(), slopes.end(),
                                    [&](const loop::ExpectedSlopes& s) { return s.v_mps == window.v_mps; });
    if (found == slopes.end()) continue;
    const double eps = restitution(law, window.v_mps);
    const double lo = eps - kDistances / found->rising, hi = eps + kDistances / found->falling;
    for (std::size_t k = 0; k <= kBins; ++k)
      window.bins.eps_edges.push_back(lo + (hi - lo) * static_cast<double>(k) / static_cast<double>(kBins));
    window.bins.counts.assign(kBins, 0);
    used.push_back(std::move(window));
  }
  return used;
}

}  // namespace

Simulation simulate(const std::string& options_json) {
  const SimulateCall call(options_json);
  const sim::SimulationConfig config = call.simulation();
  const synthesis::SynthesisConfig sound_config = synthesis_config(call.synthesized, call.seed.seed, 1);
  Simulation made;
  with_threads(1, [&] {
    const Impacts impacts = sim::simulate(config, call.surface(config)).impacts;
    if (impacts.rows.empty()) throw InvalidArgument("no drop had an impact");
    const synthesis::SyntheticRecording recording(impacts, sound_config);
    made.sound = {recording.samples_as_read_back(),
                  static_cast<double>(sound_config.rate_hz),
                  static_cast<int>(sound_config.channels.size()),
                  "simulated",
                  {},
                  {},
                  {}};
    made.truth = synthesis::truth_table(recording.truth(), "simulated");
    made.impacts = to_table(impacts);
  });
  made.law_json = law_json(config);
  return made;
}

std::string scatter(const std::string& options_json) {
  const SimulateCall call(options_json);
  const sim::SimulationConfig config = call.simulation();
  const sim::ContactOffset offset = loop::contact_offset_of(
      config.ball, nullptr, sim::radius_law_from_text(call.simulated.radius_law), call.simulated.n_asperities, 1);
  std::optional<loop::ScatterTheory> theory;
  std::vector<fit::HistogramFit> windows = windows_of_fit();
  if (offset.smooth_share <= kMostSmooth)
    with_threads(1, [&] {
      const Impacts impacts = sim::simulate(config, call.surface(config)).impacts;
      theory = loop::scatter_theory(config, offset, impacts, windows);
      if (!theory) return;
      windows = with_bins(std::move(windows), config.law, theory->slopes);
      theory = loop::scatter_theory(config, offset, impacts, windows);
    });
  if (!theory) return json_text(Object{{"smooth_share", offset.smooth_share}, {"densities", Values{}}});
  Values densities;
  for (std::size_t k = 0; k < windows.size(); ++k) {  // none is without impacts
    Object density = object_of(theory->densities[k]);
    density.emplace_back("v_lo_mps", windows[k].v_lo_mps);
    density.emplace_back("v_hi_mps", windows[k].v_hi_mps);
    density.emplace_back("eps_edges", windows[k].bins.eps_edges);
    densities.push_back(std::move(density));
  }
  Object all = object_of(*theory);
  for (auto& [name, value] : all)
    if (name == "densities") value = std::move(densities);
  all.emplace_back("n_drops", config.n_drops);
  all.emplace_back("smooth_share", offset.smooth_share);
  return json_text(all);
}

}  // namespace bouncelab::web
