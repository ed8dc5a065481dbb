// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of many recordings, of samples and studies are called and what they are, key by key (docs/formats.md
// is made of these texts).
#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

namespace {

/// What is one for all only where groups are not seen to differ.
template <auto Member>
auto if_one(const BetweenRecordings& b) {
  return b.groups_differ() ? std::nullopt : std::optional(std::invoke(Member, b));
}

}  // namespace

Description members_of(const StandardDeviation*) {
  static constexpr Member all[]{member<&StandardDeviation::value>("value", "Standard deviation"),
                                member<&StandardDeviation::ci95>("ci95", "By profile likelihood")};
  return all;
}

Description members_of(const Drift*) {
  using D = Drift;
  static constexpr Member all[]{computed(
                                    "per", [](const D& d) { return d.by_date ? "day" : "recording"; },
                                    "`day`; `recording` where fewer than half have a date: in their order"),
                                member<&D::slope>("slope", "An estimate"),
                                member<&D::p_value>("p_value", "p"),
                                member<&D::begin>("begin", "Days since 1970-01-01, or the number of the recording"),
                                member<&D::end>("end", "Likewise"),
                                member<&D::middle>("middle", "Likewise; the pooled ε belongs to it")};
  return all;
}

Description members_of(const GroupRow*) {
  static constexpr Member all[]{member<&GroupRow::name>("name", "The plate or the day"),
                                member<&GroupRow::n>("n", "Recordings"),
                                member<&GroupRow::offset>("offset", "Mean offset from the pooled ε at `v_mps`"),
                                member<&GroupRow::se>("se", "Its standard error")};
  return all;
}

Description members_of(const GroupRestitution*) {
  using G = GroupRestitution;
  static constexpr Member all[]{
      member<&G::name>("name", "The plate, or the recording"),
      member<&G::n>("n", "Its recordings, outliers left out; of single recordings their drops"),
      member<&G::v_mps>("v_mps", "Speed"),
      member<&G::eps>("eps", "ε there, an estimate, by the recordings of this group"),
      member<&G::prediction95>(
          "prediction95",
          "Where ε of one more recording of this group (of single recordings: drop) is expected to be measured there; "
          "`null`: there is one in each"),
      member<&G::nodes>("nodes", "ε at each speed of comparison that the group reaches: `[{v_mps, eps, se, ci95}]`")};
  return all;
}

Description members_of(const Grouping*) {
  static constexpr Member all[]{
      member<&Grouping::effect>(
          "effect",
          "`none` (`notes` say why), `fixed` (2 to 4 plates: a constant for each) or `random` (5 or more, and 5 "
          "recordings more than groups)"),
      member<&Grouping::deviation>("deviation", "`null`, or as `tau`"),
      member<&Grouping::rows>("rows", "`name`, `n`, `offset`, `se`")};
  return all;
}

Description members_of(const CampaignNode*) {
  using N = CampaignNode;
  static constexpr Member all[]{
      member<&N::v_mps>("v_mps", "A speed of comparison: 0.5, 0.63, 0.8, 1, 1.25 m/s and so on, ten a decade (ISO 3)"),
      member<&N::n>("n", "Recordings that reach it, outliers left out"), member<&N::eps>("eps", "ε there, an estimate"),
      member<&N::prediction95>("prediction95", "Where ε of one more recording is expected to be measured there")};
  return all;
}

Description members_of(const BetweenRecordings*) {
  using B = BetweenRecordings;
  static constexpr Member all[]{
      member<&B::n_recordings>("n_recordings", "Recordings"),
      member<&B::n_used>("n_used", "Those compared, outliers among them"),
      member<&B::n_samples>("n_samples", "Their samples"),
      where_ok<&B::v_mps>("v_mps",
                          "The speed at which they are compared: that which most of them reach, and of several the "
                          "middle one. All that follows is at this speed but for `nodes`"),
      where_ok<if_one<&B::eps>>(
          "eps",
          "ε of all, an estimate whose error includes what differs between recordings, in the middle of the campaign; "
          "`null` where groups differ"),
      where_ok<if_one<&B::prediction95>>(
          "prediction95",
          "Where ε of one more recording is expected to be measured, with such errors as the others have; likewise"),
      where_ok<if_one<&B::nodes>>("nodes",
                                  "The same at each speed that half as many recordings reach, or more; see below; "
                                  "likewise"),
      where_ok<&B::tau>(
          "tau",
          "`value`, `ci95`: standard deviation of ε between recordings, of one plate and day where these have "
          "one, beyond the recordings' own errors; `ci95` by profile likelihood"),
      where_ok<&B::heterogeneity>("heterogeneity",
                                  "`chi2`, `ndf`, `p_value`: whether the recordings (outliers too) differ at all"),
      member<&B::drift>("drift", "`null`, or ε over the campaign, see below"),
      member<&B::plates>("plates", "Groups by plate, with the drift taken out"),
      member<&B::days>("days", "Groups by day, with the plates taken out"),
      member<&B::differences>(
          "differences",
          "`null`, or by what plates (where some have several recordings), else two to four recordings "
          "differ; see below")};
  return all;
}

Description members_of(const GroupDifference*) {
  using D = GroupDifference;
  static constexpr Member all[]{
      member<&D::reference>("reference", "A group"),
      member<&D::group>("group", "Another; all is of it less the reference"),
      member<&D::v_mps>("v_mps", "Speed"),
      member<&D::eps>("eps", "Estimate of the difference of ε there"),
      member<&D::ndf>("ndf", "Degrees of freedom of Student's t; 0: how units of a group differ is not known"),
      member<&D::detectable>("detectable", "A difference there that such data show in four of five experiments"),
      member<&D::p_value>("p_value",
                          "Of so large a difference there by chance, if the groups differ as their units do; times the "
                          "number of pairs; "
                          "`null`: one unit in each"),
      member<&D::nodes>("nodes", "The difference at each speed that both reach: `[{v_mps, eps, se, ci95}]`")};
  return all;
}

Description members_of(const GroupDifferences*) {
  using D = GroupDifferences;
  static constexpr Member all[]{
      member<&D::differ>("differ",
                         "Some pair has p < 0.05, or none has a p: each group has its own ε, and there is none of all"),
      computed(
          "unit", [](const D& d) { return to_string(d.unit); },
          "By what differs within a group differences are judged: `recordings` where a plate has several, else "
          "`drops`"),
      member<&D::groups>("groups", "ε of each, see below"),
      member<&D::rows>("rows", "Every pair of up to four groups, see below")};
  return all;
}

Description members_of(const RestitutionCounts*) {
  using C = RestitutionCounts;
  static constexpr Member all[]{
      member<&C::n_onsets>("n_onsets", "Impacts read"),
      member<&C::n_drops>("n_drops", "Drops"),
      member<&C::n_samples>("n_samples", "Coefficients of restitution"),
      member<&C::n_flagged>("n_flagged", "Of these with a flag: they stay out of the fit"),
      member<&C::eps_median>("eps_median", "Of the others"),
      member<&C::n_heights_contradicted>(
          "n_heights_contradicted", "Drops whose flights contradict `--drop-height`: their first impact is left out"),
      member<&C::height_suggested_m>("height_suggested_m",
                                     "Height of the fall that these suggest, their median; `null`: none"),
      computed(
          "breaks",
          [](const C& c) {
            Object breaks;
            for (const auto& [reason, n] : c.breaks) breaks.emplace_back(name_of(reason), value_of(n));
            return breaks;
          },
          "Places where the chain of a drop is broken: reason → number")};
  return all;
}

Description members_of(const IntervalPrediction*) {
  using P = IntervalPrediction;
  static constexpr Member all[]{member<&P::impact>("impact", "That the interval follows"),
                                member<&P::measured_s>("found_s", "As measured"),
                                member<&P::predicted_s>("expected_s", "By the law; `null` without one"),
                                member<&P::sigma_s>("sigma_s", "Standard error of the measured one")};
  return all;
}

}  // namespace bouncelab::fit
