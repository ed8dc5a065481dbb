// SPDX-License-Identifier: GPL-3.0-or-later
/// The parts of fit.json.
#pragma once

#include <vector>

#include "text/json_values.hpp"

namespace bouncelab::fit {

Json json_of(const LawFit& fit);
Json comparison_of(const std::vector<LawComparison>& comparison);
Json json_of(const MemoryFit& m);
Json tests_of(const MemoryFit& m);
Json roughness_of(const MemoryFit& m);
Json json_of(const ScatterModel& s);
Json json_of(const HistogramFit& h);
Json json_of(const ShapeFit& shape);
Json json_of(const ErrorBudget& budget);
Json json_of(const BudgetRow& r);
Json json_of(const TimingNoise& t);
Json json_of(const DemExport& h);
Json json_of(const RecordingsTest& t);
Json json_of(const RecordingFit& r);
Json json_of(const PlainAnswer& answer);
Json json_of(const SpeedAndRestitution& at);
Json json_of(const DropsSeen& seen);

}  // namespace bouncelab::fit
