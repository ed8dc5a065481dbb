// SPDX-License-Identifier: GPL-3.0-or-later
#include "simulation.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/loop/scatter_theory.hpp"
#include "bouncelab/sim/sim.hpp"
#include "commands/simulate_command.hpp"
#include "commands/synthesize_command.hpp"
#include "files.hpp"
#include "json/json_text.hpp"
#include "json/stage_json.hpp"
#include "options.hpp"

namespace bouncelab::web {
namespace {

/// Options of `simulate` and `synthesize`.
struct SimulateCall {
  cli::SimulateOptions simulated;
  cli::SynthesizeOptions synthesized;
  cli::Run run;

  explicit SimulateCall(const std::string& options_json) {
    static const Description ball = cli::ball_options("steel:6mm on glass");
    run = parse({{"", &ball, &simulated.world},
                 {"", &members_of(&simulated), &simulated},
                 {"", &members_of(&synthesized), &synthesized},
                 cli::disturbances_section(synthesized)},
                options_json);
    synthesized.world = simulated.world;
  }
};

/// The simulated law as text and as points up to the speed of the first impact.
std::string law_json(const sim::SimulationConfig& config) {
  constexpr int kPoints = 100;
  const double fastest_mps = std::sqrt(2.0 * config.gravity_mps2 * config.drop_height_max_m);
  nlohmann::ordered_json curve = nlohmann::ordered_json::array();
  for (int k = 1; k <= kPoints; ++k) {
    const double v_mps = fastest_mps * k / kPoints;
    curve.push_back({{"v_mps", v_mps}, {"eps", restitution(config.law, v_mps)}});
  }
  return cli::json_text(nlohmann::ordered_json{{"law", describe(config.law)}, {"curve", curve}});
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
  const WorkingFolder folder;
  SimulateCall call(options_json);
  cli::SimulateOptions& simulated = call.simulated;
  cli::SynthesizeOptions& synthesized = call.synthesized;
  const cli::Run& run = call.run;
  simulated.out = synthesized.impacts = "impacts.csv";
  synthesized.out = "simulated.wav";
  synthesized.truth = "truth.csv";
  Simulation made;
  with_threads(1, [&] {
    for (const cli::Outcome& outcome : {cli::run_simulate(simulated, run), cli::run_synthesize(synthesized, run)})
      if (!outcome.error.empty()) throw InvalidArgument(outcome.error);
  });
  made.impacts_csv = read_file(simulated.out);
  made.truth_csv = read_file(synthesized.truth);
  made.law_json = law_json(cli::simulation_config(simulated, run.common));
  made.sound = read_recording(synthesized.out);
  return made;
}

std::string scatter(const std::string& options_json) {
  const WorkingFolder folder;
  const SimulateCall call(options_json);
  const sim::SimulationConfig config = cli::simulation_config(call.simulated, call.run.common);
  const sim::ContactOffset offset =
      loop::contact_offset_of(config.ball, nullptr, sim::radius_law_from_text(call.simulated.radius_law),
                              call.simulated.n_asperities, call.run.common.n_threads);
  std::optional<loop::ScatterTheory> theory;
  std::vector<fit::HistogramFit> windows = windows_of_fit();
  if (offset.smooth_share <= kMostSmooth)
    with_threads(1, [&] {
      const Impacts impacts = sim::simulate(config, cli::surface_of(call.simulated, config)).impacts;
      theory = loop::scatter_theory(config, offset, impacts, windows);
      if (!theory) return;
      windows = with_bins(std::move(windows), config.law, theory->slopes);
      theory = loop::scatter_theory(config, offset, impacts, windows);
    });
  const double smooth_share = offset.smooth_share;
  if (!theory) {
    return cli::json_text(
        nlohmann::ordered_json{{"smooth_share", smooth_share}, {"densities", nlohmann::ordered_json::array()}});
  }
  nlohmann::ordered_json json = cli::scatter_json(*theory);
  json["n_drops"] = config.n_drops;
  json["smooth_share"] = smooth_share;
  for (std::size_t k = 0; k < windows.size(); ++k) {  // none is without impacts
    json["densities"][k]["v_lo_mps"] = windows[k].v_lo_mps;
    json["densities"][k]["v_hi_mps"] = windows[k].v_hi_mps;
    json["densities"][k]["eps_edges"] = windows[k].bins.eps_edges;
  }
  return cli::json_text(json);
}

}  // namespace bouncelab::web
