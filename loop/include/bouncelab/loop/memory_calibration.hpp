// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/table.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/sim/contact.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::loop {

// Does the fit with memory (bouncelab/fit/memory_fit.hpp) keep within the errors it states, and does its test say so
// where it cannot? Experiments under conditions drawn at random, of the paper's ball and law, each simulated, for one
// half recorded and detected, fitted with and without memory, and compared with the truth.

struct MemoryCalibrationConfig {
  std::size_t n_experiments = 200;                  ///< >= 1
  std::int64_t n_drops_min = 5, n_drops_max = 100;  ///< 1 <= min <= max <= 10,000; log-uniform between them
  std::int64_t n_impacts = 96;                      ///< of a drop, 12 to 1000
  std::uint64_t seed = 1;
  int n_threads = 0;  ///< 0: all cores; the result does not depend on it
};

/// Of one experiment. Radius laws and rules of contact take turns, so that every 30 experiments each meets each; all
/// else is drawn.
struct MemoryConditions {
  /// Constant 1e-3, uniform 0.5e-3 to 1.5e-3, normal of mean 1e-3 and lognormal of median 1e-3 with a relative width
  /// from 0.01 to 0.1 (0.03 where frictionless), exponential of a mean from 3e-6 to 5e-5; both drawn log-uniformly.
  sim::RadiusLaw radius_law;
  std::int64_t n_asperities = 0;  ///< log-uniform from 3e4 to 1e7; where q stays below 7e-5 and the sphere is covered
  /// Paper's with beta 1, 0.5 and 0.9; frictionless; Coulomb's and Stronge's with mu = 0.2.
  sim::ContactModel contact;
  std::int64_t n_drops = 0;
  /// Standard deviation of each of the two components of spin along the plate, normal, drawn for each drop: log-uniform
  /// from 2 to 20 in a quarter of the experiments, else 0, a clean release [rad/s].
  double release_spin_radps = 0.0;
  bool drag = false;       ///< in air, and corrected for it; in half of the experiments
  bool sound = false;      ///< times from sound, 96 kHz with a signal-to-noise ratio of 30 dB, in half; else true ones
  double q = 0.0;          ///< c s2 of law, number and rule (docs/physics.md, 7)
  std::uint64_t seed = 0;  ///< of surface, drops and sound
};

/// @param number  of the experiment, from 0. @throws InvalidArgument where the configuration is out of range
MemoryConditions memory_conditions(const MemoryCalibrationConfig& config, std::size_t number);

struct CalibratedQuantity {
  std::string name;  ///< eps_025, eps_060, eps_120 (at 0.25, 0.6, 1.2 m/s), A2, A4, A5, q
  double truth = 0.0;
  std::optional<fit::Estimate> with_memory;  ///< absent where that fit failed
  std::optional<fit::Estimate> independent;  ///< impacts taken as independent; has no q
};

struct MemoryExperiment {
  MemoryConditions conditions;
  std::size_t n_used = 0;  ///< impacts fitted
  fit::FitStatus status = fit::FitStatus::too_few_samples;
  std::vector<Note> objections;              ///< of the fit with memory: why it failed, or what speaks against it
  bool holds = false;                        ///< its test passes
  std::optional<double> anderson_darling_p;  ///< of the probability transforms
  std::optional<fit::MemoryTest> mechanism, by_speed, release, leak;
  std::optional<fit::DropsTest> between_drops;
  std::optional<fit::Estimate> keep;           ///< share of the reservoir that outlasts a bounce
  std::vector<CalibratedQuantity> quantities;  ///< always the seven
};

/// One experiment: a pure function of its arguments.
MemoryExperiment run_memory_experiment(const MemoryConditions& conditions, std::int64_t n_impacts);

/// All experiments, in parallel.
/// @param progress  in experiments; may throw to stop
/// @throws InvalidArgument where the configuration is out of range
std::vector<MemoryExperiment> calibrate_memory(const MemoryCalibrationConfig& config,
                                               const ProgressCallback& progress = {});

/// One quantity over some experiments; absent where there are too few.
struct MemoryCalibrationRow {
  std::string quantity;
  std::size_t n = 0;
  std::optional<double> pull_mean, pull_sd;  ///< (estimate - truth) / standard error
  std::optional<double> coverage68, coverage95;
  std::optional<double> rms_error, rms_error_independent;
  std::optional<double> gain;  ///< mean square error of the fit to independent impacts over that with memory
};
Description members_of(const MemoryCalibrationRow*);

/// Experiments that have a condition in common.
struct MemoryCalibrationGroup {
  std::string family, name;  ///< "radii", "exponential"
  std::size_t n = 0;         ///< experiments
  std::size_t n_failed = 0;  ///< of them: no fit
  std::size_t n_holds = 0;   ///< of them: the test passes
  /// The seven, and all eps together. In family "test" of all fits in the group, in others of those whose test passes.
  std::vector<MemoryCalibrationRow> rows;
};
Description members_of(const MemoryCalibrationGroup*);

/// Families: test (any, passed, failed), model (as the fit assumes; radii that make offsets other than normal, with a
/// clean release; release with spin), radii, contact, release, drag, times, drops. The groups of each family but the
/// first have every experiment once.
std::vector<MemoryCalibrationGroup> memory_calibration_groups(const std::vector<MemoryExperiment>& experiments);

/// One row for each experiment: docs/formats.md.
Table to_table(const std::vector<MemoryExperiment>& experiments);

}  // namespace bouncelab::loop
