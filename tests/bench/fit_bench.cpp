// SPDX-License-Identifier: GPL-3.0-or-later
// The law's fit with profile intervals against the same likelihood in iminuit (fit_iminuit.py), and the histograms.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "../fit/synthetic_samples.hpp"
#include "bouncelab/core/csv.hpp"
#include "bouncelab/fit/fit.hpp"

namespace {

using namespace bouncelab;

double seconds_of(auto&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// What fit_iminuit.py prints; null where it does not run (no python3-iminuit).
nlohmann::json run_iminuit(const std::string& samples) {
  const std::string output = samples + ".json";
  const std::string line = "/usr/bin/python3 " BOUNCELAB_FIT_IMINUIT " " + samples + " > " + output;
  if (std::system(line.c_str()) != 0) return nullptr;
  std::ifstream in(output);
  return nlohmann::json::parse(in);
}

void compare(std::size_t n, double noise_at_1mps) {
  testing::SyntheticRun run;
  const auto samples = testing::independent_samples(run, n, 0.2, 1.4, noise_at_1mps);
  const std::string path = (std::filesystem::temp_directory_path() / "bouncelab_fit_bench_samples.csv").string();
  {
    std::ofstream out(path);
    write_csv(out, to_table(samples));
  }
  fit::LawFit fit;
  fit::LawFitConfig config;
  config.node_speeds_mps = {0.25, 0.6, 1.2};
  config.n_scatter_terms = 3;  // as in fit_iminuit.py
  const double seconds = seconds_of([&] { fit = fit::fit_law(samples, config); });
  std::printf("%zu samples, timing noise %g of the scatter\n", n, noise_at_1mps / 5e-4);
  std::printf("  law with profile intervals of 3 nodes and 3 constants: %.2f s, status %s\n", seconds,
              fit::to_string(fit.status));
  std::vector<fit::HistogramFit> histograms;
  const double seconds_histograms = seconds_of([&] { histograms = fit::fit_histograms(samples, {}, fit); });
  std::printf("  histograms of %zu windows: %.2f s\n", histograms.size(), seconds_histograms);
  const auto minuit = run_iminuit(path);
  if (minuit.is_null()) {
    std::printf("  iminuit did not run: install python3-iminuit and python3-scipy\n");
    return;
  }
  std::printf("  iminuit, profile intervals of 3 nodes: %.1f s (%d calls; MIGRAD alone %.1f s)\n",
              minuit["seconds"].get<double>(), minuit["n_calls"].get<int>(), minuit["seconds_fit"].get<double>());
  std::printf("  ratio iminuit / bouncelab: %.1f\n", minuit["seconds"].get<double>() / seconds);
  for (std::size_t j = 0; j < 3; ++j) {
    const fit::Estimate& e = fit.nodes[j].eps;
    std::printf("  eps(%.2f): %.7f [%.7f, %.7f] here, %.7f [%.7f, %.7f] iminuit\n", fit.nodes[j].v_mps, e.value,
                e.ci95->lo, e.ci95->hi, minuit["nodes"][j].get<double>(), minuit["ci95"][j][0].get<double>(),
                minuit["ci95"][j][1].get<double>());
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t n = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 220000;
  compare(n, 1e-4);  // none at all leaves a kink on which MIGRAD fails
  compare(n, 8.7e-4);
}
