// SPDX-License-Identifier: GPL-3.0-or-later
// The closed loop, stage by stage: impact times -> sound -> impact times -> constants. bouncelab::loop::run_loop does
// the same in one call, in parallel.
#include <bouncelab/acoustic/acoustic.hpp>
#include <bouncelab/fit/fit.hpp>
#include <bouncelab/loop/loop.hpp>
#include <bouncelab/sim/sim.hpp>
#include <cstdio>

int main() {
  using namespace bouncelab;

  // simulate: 8 drops of the paper's ball with 10,000 asperities
  sim::SimulationConfig experiment;
  experiment.n_drops = 8;
  const sim::Surface surface = sim::make_surface(experiment.ball, 10'000, sim::UniformRadii{}, experiment.seed);
  const Impacts impacts = sim::simulate(experiment, surface).impacts;

  // synthesize: one recording of a glass plate, piezo sensor, 96 kHz, signal-to-noise ratio 30 dB
  const synthesis::SynthesisConfig sound;
  const synthesis::SyntheticRecording recording(impacts, sound);
  const std::vector<float> samples = recording.samples_as_read_back();

  // detect: the detector is given the samples and their rate, nothing else
  const Onsets onsets = detection::detect(samples, sound.rate_hz, "loop").onsets;
  const loop::TrueTimes truth = loop::true_times_from_table(synthesis::truth_table(recording.truth(), "loop"), "truth");
  const double sound_s = static_cast<double>(samples.size()) / sound.rate_hz;
  const loop::DetectorScore score = loop::score_detector(truth, onsets, sound_s, 0.0);
  const auto& [n_true, n_marked, n_found] = score.agreement[loop::kJitterTolerance];
  std::printf("%zu impacts, %zu found, %zu missed, %zu invented, time error within drops %.2g us rms\n", n_true,
              n_found, n_true - n_found, n_marked - n_found, 1e6 * score.within_drops_s.value_or(0.0));

  // restitution and fit. Tables are lists of rows: Impact, Onset, RestitutionSample have members by the names of their
  // columns
  const RestitutionSamples eps = fit::restitution_samples(onsets, {}).samples;
  for (std::size_t k = 0; k < 3; ++k)
    std::printf(
        "impact %lld: simulated %.6f s after the release, found at %.6f s (standard error %.2g us), "
        "eps(%.3f m/s) = %.4f\n",
        static_cast<long long>(impacts.rows[k].impact), impacts.rows[k].t_s, onsets[k].t_s,
        1e6 * onsets[k].sigma_t_s.value_or(0.0), eps[k].v_mps, eps[k].eps);

  // the peak of p(eps) follows the law that was simulated; the mean of a rough ball lies beside it
  // by default without the fit with memory, which takes seconds; UseMemory::where_long gives the command line's numbers
  const fit::FitResult fit = fit::fit_all(eps, {});
  for (const fit::CurveNode& node : fit.curve->nodes)
    std::printf("at %.2f m/s: mean eps %s, peak %s, law %.6f, pull %.2f\n", node.v_mps,
                fit::in_words(node.eps.value, node.eps.se).c_str(),
                fit::in_words(node.peak->value, node.peak->se).c_str(), restitution(experiment.law, node.v_mps),
                (node.peak->value - restitution(experiment.law, node.v_mps)) / node.peak->se.value_or(1.0));
}
