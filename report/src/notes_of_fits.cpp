// SPDX-License-Identifier: GPL-3.0-or-later
// What a user should know of a fit and of its samples.
#include <algorithm>
#include <cmath>
#include <utility>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/text.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "words.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

using Notes = std::vector<Note>;

/// What one drop's impacts share cannot be seen without other drops. (Figures: docs/physics.md, errors by drop.)
void note_few_drops(const DropCount& drops, Notes& notes) {
  if (drops.n == 0 || drops.errors == ErrorBasis::by_drop) return;
  notes.push_back({NoteKind::few_drops,
                   {},
                   drops.n >= kFewestDrops ? "nearly all that is known comes from one drop"
                                           : formatted("%zu %s", drops.n, drops.n == 1 ? "drop" : "drops")});
}

/// Drops that differ by more than single bounces do, and visibly: something is another from drop to drop.
void note_drops_that_differ(const FitResult& result, Notes& notes) {
  constexpr double kOfLost = 0.05;
  if (!result.is_one_ball || !result.curve || !result.curve->scatter_of_drops) return;
  const Curve& curve = *result.curve;
  if (result.n_used < 2 * curve.n_drops) return;  // drops of one bounce each: what is of the drop is not told from it
  const Estimate& eps = curve.nodes[curve.nodes.size() / 2].eps;
  const double differ = *curve.scatter_of_drops, of_interval = differ / std::sqrt(static_cast<double>(curve.n_drops));
  if (differ < curve.scatter || differ < kOfLost * (1.0 - eps.value)) return;
  if (of_interval < 0.5 * eps.se.value_or(0.0)) return;  // large errors of the times, of a stop watch, make it wide
  notes.push_back({NoteKind::drops_differ, {static_cast<double>(curve.n_drops), differ, curve.scatter}});
}

void note_law(const FitResult& result, Notes& notes) {
  const LawFit& law = result.law;
  if (result.constants.status == FitStatus::not_applicable) return;  // they are none about it
  // with memory the impacts need not scatter as if they were independent
  if (law.pearson && law.pearson->p_value < 0.001 && !memory_holds(result)) {
    double ratio = 0.0;
    for (const ResidualBin& bin : law.residuals) ratio += bin.scatter_ratio / static_cast<double>(law.residuals.size());
    if (ratio < 0.8)
      notes.push_back({NoteKind::timing_too_large, {ratio}});
    else
      notes.push_back({NoteKind::scatter_not_as_fitted,
                       {law.pearson->chi2 / law.pearson->ndf, law.pearson->p_value},
                       law.drops.errors == ErrorBasis::by_drop
                           ? "the standard errors come from the differences between drops and do not depend on it"
                           : "the standard errors may be too small"});
  }
  if (!law.outliers.empty()) notes.push_back({NoteKind::outliers, {static_cast<double>(law.outliers.size())}});
}

/// Beyond the speeds measured, by more than a tenth, it is the law that speaks.
void note_speeds(const std::vector<double>& speeds_mps, const RestitutionSamples& used, Notes& notes) {
  if (used.empty()) return;
  const auto [slowest, fastest] =
      std::minmax_element(used.begin(), used.end(), [](const auto& a, const auto& b) { return a.v_mps < b.v_mps; });
  for (const double v_mps : speeds_mps)
    if (v_mps < 0.9 * slowest->v_mps || v_mps > 1.1 * fastest->v_mps)
      return notes.push_back({NoteKind::beyond_speeds, {v_mps, slowest->v_mps, fastest->v_mps}});
}

/// Where the noise that neighbouring samples share is not what the detector states.
void note_timing(const ErrorBudget& budget, Notes& notes) {
  if (!budget.timing || !budget.timing->stated_s || !(*budget.timing->stated_s > 0.0)) return;
  const TimingNoise& t = *budget.timing;
  const double stated2 = *t.stated_s * *t.stated_s;
  if (std::abs(t.variance_s2 - stated2) < 4.0 * t.variance_se_s2 || !t.sigma_s) return;
  // a tenth of the noise is of no consequence however well it is measured
  if (std::abs(*t.sigma_s / *t.stated_s - 1.0) < 0.1) return;
  notes.push_back({NoteKind::timing_not_as_stated, {1e6 * *t.sigma_s, 1e6 * *t.stated_s}});
}

void note_samples(const RestitutionSamples& used, Notes& notes) {
  Implausible implausible;
  for (const RestitutionSample& sample : used) implausible.add(sample);
  for (Note& note : implausible.notes()) notes.push_back(std::move(note));
}

void note_unstated_errors(const RestitutionSamples& used, Notes& notes) {
  const auto unknown =
      std::count_if(used.begin(), used.end(), [](const auto& s) { return !s.sigma_eps || !(*s.sigma_eps > 0.0); });
  if (unknown > 0)
    notes.push_back({NoteKind::errors_not_stated, {static_cast<double>(unknown), static_cast<double>(used.size())}});
}

/// Rows that a flag of the detector or of the intervals excludes were counted where the flag was set. Rows that are
/// excluded by their values, or by a word that nothing of ours writes, were not.
void note_rows_left_out(const LeftOut& left_out, Notes& notes) {
  for (const auto& [reason, first] : left_out.first) {
    const std::optional<Flag> flag = flag_named(reason);
    if (flag && *flag != Flag::not_finite) continue;
    std::string why = "they have the flag " + reason;
    if (flag) why = "a number is not finite";
    if (reason == "speed_not_positive") why = "the speed is below 1e-6 m/s";
    if (reason == "contact_most_of_bounce") why = "the ball named touches the floor for most of that bounce";
    notes.push_back(
        {NoteKind::rows_left_out, {static_cast<double>(left_out.n.at(reason)), static_cast<double>(first)}, why});
  }
}

/// Few are told where the flags were set; of many it is likelier that the rule is wrong.
void note_wrong_intervals(const RestitutionSamples& used, const LeftOut& left_out, Notes& notes) {
  constexpr double kMany = 0.2;
  double n = 0.0, n_all = static_cast<double>(used.size());
  for (const auto& [reason, n_here] : left_out.n) {
    n_all += static_cast<double>(n_here);
    if (reason == name_of(Flag::missing_impact) || reason == name_of(Flag::extra_impact))
      n += static_cast<double>(n_here);
  }
  if (n > kMany * n_all) notes.push_back({NoteKind::many_intervals_odd, {n, n_all}});
}

/// @param of_plates  plates are fitted apart, each as what it is
void note_mixed_conditions(const RestitutionSamples& used, bool of_plates, Notes& notes) {
  const auto differs = [&](const RestitutionSample& s) {
    SampleConditions conditions = s.conditions;
    if (of_plates) conditions.plate = used.front().conditions.plate;
    return conditions != used.front().conditions;
  };
  if (const auto n = std::count_if(used.begin(), used.end(), differs); n > 0)
    notes.push_back({NoteKind::mixed_conditions, {static_cast<double>(n)}});
}

/// Of the samples alone, whatever is fitted to them.
void note_all_samples(const RestitutionSamples& used, const LeftOut& left_out, bool of_plates, Notes& notes) {
  if (auto twice = note_of_repeated_drops(used)) notes.push_back(*std::move(twice));
  note_samples(used, notes);
  note_rows_left_out(left_out, notes);
  note_wrong_intervals(used, left_out, notes);
  note_mixed_conditions(used, of_plates, notes);
}

/// What speaks against the fit with memory, and what is open of it: it needs a radius and a moment of inertia.
void note_memory(const MemoryFit& memory, Notes& notes) {
  notes.insert(notes.end(), memory.objections.begin(), memory.objections.end());
  if (memory.status == FitStatus::ok && !memory.ball)
    notes.push_back({NoteKind::memory_without_ball, {kSolidBallInertia, Ball{}.radius_m}});
}

/// What most of the uncertainty is, and what would shrink it; nothing where it is the ball's own scatter.
void note_largest_part(const Curve& curve, const SampleConditions& of, Notes& notes) {
  constexpr double kMost = 0.5;
  const double drag = curve.share_of_drag, contact = curve.share_of_contact;
  if (std::max(drag, contact) < kMost) return;
  notes.push_back(
      {drag > contact ? NoteKind::uncertain_air : NoteKind::uncertain_contact,
       {},
       !of.ball         ? "name the ball to reduce it (--ball)"
       : drag > contact ? "drop the ball from less high to reduce it"
       : !of.plate && contact_duration(*of.ball, kGlass).has_value() && !contact_duration(*of.ball, of.plate)
           ? "name the floor to reduce it (--plate)"
           : "drop the ball from higher to reduce it"});
}

}  // namespace

Note note_of(const KindsOfDrops& kinds) {
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(log10(kinds.eps_upper - kinds.eps_lower))), 2, 8);
  return {NoteKind::two_kinds_of_drops,
          {},
          formatted("%.*f in %zu of them and about %.*f in %zu", decimals, kinds.eps_lower, kinds.n_lower, decimals,
                    kinds.eps_upper, kinds.n_upper)};
}

void Implausible::add(const RestitutionSample& sample) {
  ++n_;
  n_impossible_ += sample.eps < 0.0 || sample.eps > 1.0;
  n_speeds_ += sample.v_mps > 20.0 || sample.v_mps < 0.005;
  of_heights_ = sample.conditions.of_heights;
}

std::vector<Note> Implausible::notes() const {
  constexpr double kMany = 0.1;
  std::vector<Note> found;
  const auto n = static_cast<double>(n_);
  const auto add_many = [&](NoteKind kind, std::size_t count, const char* subject = "") {
    if (static_cast<double>(count) > kMany * n) found.push_back({kind, {static_cast<double>(count), n}, subject});
  };
  add_many(NoteKind::eps_impossible, n_impossible_);
  add_many(NoteKind::odd_speeds, n_speeds_,
           of_heights_ ? "heights are in the unit that is stated" : "times are in seconds");
  return found;
}

std::optional<Note> note_of_repeated_drops(const RestitutionSamples& used) {
  const std::vector<RepeatedDrop> repeated = repeated_drops(used);
  if (repeated.empty()) return std::nullopt;
  const auto name = [](const std::string& recording, std::int64_t drop) {
    return "drop " + std::to_string(drop) + (recording.empty() ? "" : " of " + printable(recording));
  };
  const RepeatedDrop& first = repeated.front();
  return Note{
      NoteKind::repeated_drops,
      {static_cast<double>(first.n_bounces)},
      name(first.recording, first.drop) + " has the bounces of " + name(first.of_recording, first.of_drop) +
          (repeated.size() > 1 ? formatted(", and so have %zu more drops of others", repeated.size() - 1) : "")};
}

/// Of a plate: which of its recordings are off, and by what.
static Note note_of_recordings_within(const RecordingFit& plate) {
  const WithinPlate& within = *plate.within;
  std::vector<std::string> names;
  for (const NamedEstimate& offset : within.offsets) names.push_back(offset.name);
  names = short_names(names);
  const auto [least, greatest] =
      std::minmax_element(within.offsets.begin(), within.offsets.end(),
                          [](const auto& a, const auto& b) { return a.estimate.value < b.estimate.value; });
  const auto of = [&](auto offset) {
    return formatted("%+.2g (", offset->estimate.value) +
           printable(names[static_cast<std::size_t>(offset - within.offsets.begin())]) + ")";
  };
  return {NoteKind::recordings_differ,
          {static_cast<double>(within.test.n_recordings), within.test.p_value, 1.0},
          "they are off its ε by " + of(least) + " to " + of(greatest) +
              ", and compare --groups counts this and names outliers",
          printable(plate.recording)};
}

std::vector<Note> notes_of(const FitResult& result, const RestitutionSamples& samples, UseMemory memory) {
  LeftOut left_out;
  const PartOfSamples part = usable_samples(samples, left_out);
  const RestitutionSamples& used = *part;
  Notes notes = result.law.notes;
  if (auto differ = note_of_difference(result.recordings)) notes.push_back(*std::move(differ));
  for (const RecordingFit& row : result.recordings.rows)
    if (disagree_within(row)) notes.push_back(note_of_recordings_within(row));
  if (result.kinds_of_drops && result.is_one_ball) notes.push_back(note_of(*result.kinds_of_drops));
  note_all_samples(used, left_out, !result.recordings.plates.empty(), notes);
  note_drops_that_differ(result, notes);
  if (result.constants.why) notes.push_back(*result.constants.why);
  note_law(result, notes);
  std::vector<double> speeds_mps;
  if (result.curve)
    for (const CurveNode& node : result.curve->nodes) speeds_mps.push_back(node.v_mps);
  note_speeds(speeds_mps, used, notes);
  note_timing(result.budget, notes);
  if (!memory_holds(result)) note_few_drops(result.law.drops, notes);
  note_unstated_errors(used, notes);
  if (result.memory) note_memory(*result.memory, notes);
  if (memory == UseMemory::always && result.memory && !result.memory->holds)
    notes.push_back({NoteKind::memory_fails, {}, in_words(*result.memory)});
  if (result.curve && result.is_one_ball && !samples.empty())
    note_largest_part(*result.curve, samples.front().conditions, notes);
  order(notes);
  return notes;
}

std::vector<Note> notes_of(const RoughnessResult& result, const RestitutionSamples& samples) {
  LeftOut left_out;
  const PartOfSamples part = usable_samples(samples, left_out);
  Notes notes;
  note_all_samples(*part, left_out, false, notes);
  note_memory(result.memory, notes);
  order(notes);
  return notes;
}

}  // namespace bouncelab::report
