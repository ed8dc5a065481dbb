// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: impact times to coefficients of restitution (restitution.hpp), these to the law eps(v) (law_fit.hpp)
/// and to the histograms p(eps) (histogram_fit.hpp); fit_all does all that a report needs (the module `report` says it
/// in sentences); memory_fit.hpp has what the scatter shows of the surface, and what energy spin and sideways motion
/// hold; between_recordings.hpp compares the recordings of a campaign.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/curve.hpp"
#include "bouncelab/fit/dem_export.hpp"
#include "bouncelab/fit/error_budget.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/histogram_fit.hpp"
#include "bouncelab/fit/law_fit.hpp"
#include "bouncelab/fit/memory_fit.hpp"
#include "bouncelab/fit/recordings.hpp"
#include "bouncelab/fit/restitution.hpp"

namespace bouncelab::fit {

/// When the fit with memory is made beside the main one.
enum class UseMemory {
  never,
  where_long,  ///< from 5 drops of 30 impacts on average on; its tests decide whether its constants are stated
  always
};

struct FitConfig {
  LawFitConfig law;             ///< the main fit; the others use its nodes
  std::size_t n_goodness = 99;  ///< replicates of the main fit's Anderson-Darling test, 0: none; likewise with memory
  UseMemory memory = UseMemory::never;  ///< fill FitResult::memory, by the same law; the command line: where_long
  HistogramConfig histograms;
  BudgetConfig budget;                  ///< where the samples say nothing of themselves (budget_config_of)
  std::optional<double> dem_speed_mps;  ///< absent: the middle node
  bool compare_recordings = true;       ///< fill FitResult::recordings where there are several
  Plates plates;                        ///< each is then compared, and has fits of its own
  bool pool = false;                    ///< one answer for all, whether recordings and drops agree or not
  int n_threads = 0;                    ///< 0: all cores; the result does not depend on it
};

/// The options: nodes, form of the law, method, replicates, windows.
Description members_of(const FitConfig*);

/// Constants of the law as they are stated: of the fit with memory where that holds, else of `law`; none where the law
/// does not describe the samples, or these are of no one ball.
struct Constants {
  FitStatus status = FitStatus::too_few_samples;
  std::optional<Note> why;  ///< of the status; absent where all is well
  bool with_memory = false;
  std::vector<NamedEstimate> parameters;
  Matrix covariance;              ///< of `parameters`
  std::optional<Estimate> gamma;  ///< of a viscoelastic sphere, where one describes the samples
};
Description members_of(const Constants*);

struct FitResult {
  std::optional<Curve> curve;  ///< eps(v), the answer; absent without samples
  Constants constants;
  LawFit law;                       ///< impacts taken as independent
  std::optional<MemoryFit> memory;  ///< see FitConfig::memory; the main law is what it is without
  std::vector<HistogramFit> histograms;
  DensityPicture density;
  Recordings recordings;
  std::optional<KindsOfDrops> kinds_of_drops;  ///< where there are two
  /// One value stands for all samples: recordings and drops are seen to agree, or are to be pooled.
  bool is_one_ball = true;
  ErrorBudget budget;
  std::optional<DemExport> dem_export;
  std::size_t n_used = 0;
  std::map<std::string, std::size_t> n_left_out;  ///< by reason
};

Description members_of(const FitResult*);

/// Fits everything. Where drag and contact time are in the intervals, all fits are of the samples at the plate with the
/// values that samples and priors together make most likely, and the errors of the law include what they leave open.
/// Left out and counted: samples with a flag; with a number that is not finite or beyond those of tables (v of 1e4 m/s,
/// eps of 1e3, a negative standard error); with v of 1e-6 m/s or less.
/// @param progress  called between the fits, in steps of one
/// @throws InvalidArgument where a member of `config` is out of the range that members_of states, the orders of the
///         series are not valid, or more than fit_memory takes
FitResult fit_all(const RestitutionSamples& samples, const FitConfig& config, const ProgressCallback& progress = {});

/// Does the fit with memory hold? Its constants are then stated, and those of `law`, which takes impacts as
/// independent, are a comparison.
bool memory_holds(const FitResult& result);

}  // namespace bouncelab::fit
