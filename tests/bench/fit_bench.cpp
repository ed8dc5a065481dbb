// SPDX-License-Identifier: GPL-3.0-or-later
/// fit_bench N [FOLDER]: the law's fit with profile intervals of N samples, the histograms, and the likelihood's
/// density. With FOLDER the samples are written there, for fit_iminuit.py, which fits the same. Baseline of the
/// density: the convolution of exponentials and normal by quadrature.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "../fit/synthetic_samples.hpp"
#include "bench_lines.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/fit.hpp"
#include "law/law_likelihood.hpp"
#include "law/law_model.hpp"
#include "law/law_search.hpp"
#include "law/normal_laplace.hpp"

namespace {

using namespace bouncelab;

volatile double sink;  // what is not used is not computed

/// Simpson's rule over 8 standard deviations either side, fine enough for five digits.
[[gnu::noinline]] double density_by_quadrature(double d, double b_below, double b_above, double tau) {
  constexpr int kSteps = 256;
  const double h = 16.0 * tau / kSteps;
  double sum = 0.0;
  for (int k = 0; k <= kSteps; ++k) {
    const double u = -8.0 * tau + h * k, at = d - u;
    const double laplace = std::exp(at < 0.0 ? at / b_below : -at / b_above) / (b_below + b_above);
    const double weight = k == 0 || k == kSteps ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    sum += weight * laplace * std::exp(-0.5 * u * u / (tau * tau));
  }
  return sum * h / 3.0 / (tau * std::sqrt(2.0 * kPi));
}

void print_density() {
  constexpr int kSamples = 1024;  // whole blocks
  constexpr double kBelow = 4e-4, kAbove = 3e-4, kTau = 2e-4;
  const auto residual = [](int k) { return 2e-6 * (k - kSamples / 2); };
  fit::SidesBlock sides;
  sides.fill(kBelow, kAbove);
  fit::Block tau, inverse_tau;
  tau.fill(kTau);
  inverse_tau.fill(1.0 / kTau);
  const auto closed = [&] {
    double sum = 0.0;
    for (int k = 0; k < kSamples; k += static_cast<int>(fit::kBlockSize)) {
      fit::Block d;
      for (std::size_t i = 0; i < fit::kBlockSize; ++i) d[i] = residual(k + static_cast<int>(i));
      fit::DensityBlock f;
      fit::normal_laplace(fit::kBlockSize, d.data(), sides, tau.data(), inverse_tau.data(), 0.0, f);
      for (std::size_t i = 0; i < fit::kBlockSize; ++i) sum += f.exponent[i] + std::log(f.factor[i]);
    }
    sink = sum;
  };
  const auto quadrature = [&] {
    double sum = 0.0;
    for (int k = 0; k < kSamples; ++k) sum += std::log(density_by_quadrature(residual(k), kBelow, kAbove, kTau));
    sink = sum;
  };
  const bench::Pair pair = bench::alternating(closed, quadrature, 10);
  bench::print_line("fit", "density of a sample", "closed form, with four derivatives", pair.ours_s / kSamples, "s");
  bench::print_line("fit", "density of a sample", "convolution by quadrature", pair.baseline_s / kSamples, "s");
}

/// Value and gradient of the log-likelihood of a law in exponentials and timing errors, as a search asks for them.
void print_likelihood(double noise_at_1mps, const std::string& timing) {
  testing::SyntheticRun run;
  const RestitutionSamples samples = testing::independent_samples(run, 64000, 0.2, 1.4, noise_at_1mps);
  const fit::LawData data = fit::law_data(samples, fit::by_speed(samples));
  const fit::LawModel model = fit::make_law_model(fit::LawKind::series, {2, 4, 5}, data.v_mps);
  const fit::ScatterFamily family{false, 3, 0.6, 0.01};
  const fit::LawLikelihood likelihood(data, model, family);
  const Eigen::VectorXd theta = fit::start_values(*fit::first_look(data, model), family);
  Eigen::VectorXd gradient;
  const double all_s = bench::least_s([&] { sink = likelihood(theta, &gradient); }, 20, 0.0);
  bench::print_line("fit", "likelihood of a sample, timing noise " + timing, "with its gradient",
                    all_s / static_cast<double>(data.size()), "s");
}

void fit_samples(std::size_t n, double noise_at_1mps, const std::string& timing, const char* folder) {
  testing::SyntheticRun run;
  const auto samples = testing::independent_samples(run, n, 0.2, 1.4, noise_at_1mps);
  const std::string name = std::to_string(n) + " samples, timing noise " + timing;
  if (folder != nullptr) {
    std::ofstream out(std::filesystem::path(folder) / (name + ".csv"));
    write_csv(out, to_table(samples));
  }
  fit::LawFit fit;
  fit::LawFitConfig config;
  config.node_speeds_mps = {0.25, 0.6, 1.2};
  config.n_scatter_terms = 3;  // as in fit_iminuit.py
  const double law_s = bench::least_s([&] { fit = fit::fit_law(samples, config); }, n > 50000 ? 2 : 5, 0.0);
  bench::print_line("fit", name, "law with profile intervals", law_s, "s");
  const double histograms_s =
      bench::seconds_of([&] { sink = static_cast<double>(fit::fit_histograms(samples, {}, fit).size()); });
  bench::print_line("fit", name, "histograms", histograms_s, "s");
  for (const fit::NodeEstimate& node : fit.nodes) {
    const std::string speed = "eps(" + std::to_string(node.v_mps).substr(0, 4) + ")";
    bench::print_line("fit", name, speed + ", bouncelab", node.eps.value, "1");
    if (node.eps.se) bench::print_line("fit", name, speed + ", standard error", *node.eps.se, "1");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t n = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 220000;
  const char* const folder = argc > 2 ? argv[2] : nullptr;
  with_threads(1, [&] {
    print_density();
    print_likelihood(1e-4, "0.2 of the scatter");
    print_likelihood(8.7e-4, "1.7 of the scatter");
    fit_samples(n, 1e-4, "0.2 of the scatter", folder);  // none at all leaves a kink on which MIGRAD fails
    fit_samples(n, 8.7e-4, "1.7 of the scatter", folder);
  });
}
