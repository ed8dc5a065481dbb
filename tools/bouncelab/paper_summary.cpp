// SPDX-License-Identifier: GPL-3.0-or-later
#include "paper_summary.hpp"

#include <fmt/format.h>

#include <cmath>

#include "bouncelab/fit/conclusions.hpp"

namespace bouncelab::cli {
namespace {

Json json_of(const fit::Estimate& estimate) {
  Json json{{"value", estimate.value}};
  if (estimate.se) json["se"] = *estimate.se;
  if (estimate.ci95) json["ci95"] = {estimate.ci95->lo, estimate.ci95->hi};
  return json;
}

Json conclusions_of(const StreamedLoop& loop) {
  Json all = Json::array();
  const fit::FitResult* smooth = loop.smooth.drops.empty() ? nullptr : &loop.smooth_sound;
  for (const fit::Conclusion& c : fit::paper_conclusions(loop.sound, smooth, loop.simulation.law)) {
    Json json{{"claim", c.claim},
              {"measure", c.measure},
              {"criterion", c.criterion},
              {"holds", c.holds},
              {"detail", c.detail}};
    json["value"] = c.value ? Json(*c.value) : Json(nullptr);
    json["ci95"] = c.ci95 ? Json{c.ci95->lo, c.ci95->hi} : Json(nullptr);
    all.push_back(std::move(json));
  }
  return all;
}

/// Slopes from the simulation itself and from its sound, and what measuring makes of them.
Json slopes_of(const StreamedLoop& loop) {
  Json windows = Json::array();
  for (std::size_t k = 0; k < loop.sound.histograms.size() && k < loop.direct.histograms.size(); ++k) {
    const fit::HistogramFit &direct = loop.direct.histograms[k], &sound = loop.sound.histograms[k];
    if (!direct.slope_rising || !sound.slope_rising || !direct.slope_falling || !sound.slope_falling) continue;
    Json window{{"v_mps", sound.v_mps}, {"n_simulation", direct.n}, {"n_sound", sound.n}};
    const auto add = [&](const char* side, const fit::Estimate& in, const fit::Estimate& out) {
      window[side] = {{"simulation", json_of(in)}, {"sound", json_of(out)}, {"ratio", out.value / in.value}};
    };
    add("rising", *direct.slope_rising, *sound.slope_rising);
    add("falling", *direct.slope_falling, *sound.slope_falling);
    windows.push_back(std::move(window));
  }
  return windows;
}

Json spread_of(const fit::FitResult& fit) {
  Json spread{{"v_mps", Json::array()}, {"spread", Json::array()}};
  for (const fit::BudgetRow& row : fit.budget.rows) {
    spread["v_mps"].push_back(row.v_mps);
    spread["spread"].push_back(row.spread);
  }
  spread["exponent"] = fit.budget.width_exponent ? json_of(*fit.budget.width_exponent) : Json(nullptr);
  return spread;
}

Json shares_of(const std::vector<sim::EnergyShares>& shares) {
  Json json;
  const auto column = [&](const char* name, auto member) {
    for (const sim::EnergyShares& s : shares) json[name].push_back(s.*member);
  };
  column("impact", &sim::EnergyShares::impact);
  column("n", &sim::EnergyShares::n);
  column("vertical", &sim::EnergyShares::vertical);
  column("horizontal", &sim::EnergyShares::horizontal);
  column("rotational", &sim::EnergyShares::rotational);
  column("rotational_lo", &sim::EnergyShares::rotational_lo);
  column("rotational_hi", &sim::EnergyShares::rotational_hi);
  return json;
}

std::string ratio_text(const Json& side) {
  const auto cell = [](const Json& e) {
    return fmt::format("{:>7.0f} ± {:<4.0f}", e["value"].get<double>(), e.value("se", 0.0));
  };
  return fmt::format("{} {}  {:>6.3f}", cell(side["simulation"]), cell(side["sound"]), side["ratio"].get<double>());
}

double sound_s(const StreamedLoop& loop) {
  double sum = 0.0;
  for (const HeardBall* ball : {&loop.rough, &loop.smooth})
    for (const HeardDrop& drop : ball->drops) sum += drop.sound_s;
  return sum;
}

}  // namespace

Json paper_json(const StreamedLoop& loop) {
  return {{"conclusions", conclusions_of(loop)},
          {"slopes", slopes_of(loop)},
          {"spread",
           {{"simulation", spread_of(loop.direct)},
            {"sound", spread_of(loop.sound)},
            {"smooth_ball", spread_of(loop.smooth_sound)}}},
          {"smooth_ball",
           {{"n_drops", loop.smooth.drops.size()},
            {"n_impacts", loop.smooth.score.n_true},
            {"n_missed", loop.smooth.score.n_missed},
            {"n_invented", loop.smooth.score.n_invented}}},
          {"energy_shares", shares_of(loop.shares)}};
}

std::string paper_text(const Json& paper) {
  std::string text =
      "\nSlopes of p(eps)              rising                                falling\n"
      "  window     simulation       sound        ratio    simulation       sound        ratio\n";
  for (const Json& window : paper["slopes"])
    text += fmt::format("  {:.1f} m/s {}  {}\n", window["v_mps"].get<double>(), ratio_text(window["rising"]),
                        ratio_text(window["falling"]));
  text += "\nWhat the paper concludes\n";
  for (const Json& c : paper["conclusions"]) {
    text +=
        fmt::format("  {:<14} {}: ", c["holds"].get<bool>() ? "holds" : "DOES NOT HOLD", c["claim"].get<std::string>());
    text += c["value"].is_number() ? fmt::format("{:.4g}", c["value"].get<double>()) : "not known";
    if (c["ci95"].is_array())
      text += fmt::format(" [{:.4g}, {:.4g}]", c["ci95"][0].get<double>(), c["ci95"][1].get<double>());
    text += fmt::format(" ({}; {})\n", c["measure"].get<std::string>(), c["detail"].get<std::string>());
  }
  return text;
}

void add_work(const StreamedLoop& loop, const std::vector<std::pair<std::string, double>>& later_wall_s,
              double memory_bytes, Json& summary) {
  Json wall = Json::object(), processor = Json::object();
  for (const auto& [stage, s] : loop.wall_s) wall[stage] = s;
  for (const auto& [stage, s] : later_wall_s) wall[stage] = s;
  for (const auto& [stage, s] : loop.processor_s) processor[stage] = s;
  for (const auto& [stage, s] : later_wall_s) processor[stage] = s;  // one thread writes
  summary["sound_s"] = sound_s(loop);
  summary["seconds"] = std::move(wall);
  summary["processor_seconds"] = std::move(processor);
  summary["peak_memory_bytes"] = memory_bytes;
}

std::string work_text(const Json& summary) {
  const double hours = summary["sound_s"].get<double>() / 3600.0;
  const auto impacts = summary["n_impacts"].get<double>();
  std::string text = fmt::format("\n{:.2f} h of sound; peak memory {:.0f} MB\nProcessor time by stage\n", hours,
                                 summary["peak_memory_bytes"].get<double>() / 1e6);
  for (const auto& [stage, s] : summary["processor_seconds"].items())
    text += fmt::format("  {:<22}{:8.2f} s {:8.3f} s per hour of sound {:8.2f} us per impact\n", stage, s.get<double>(),
                        s.get<double>() / hours, 1e6 * s.get<double>() / impacts);
  return text;
}

}  // namespace bouncelab::cli
