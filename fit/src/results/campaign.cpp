// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of many recordings, of samples and studies are called and what they are, key by key (docs/formats.md
// is made of these texts).
#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

namespace {

Object pooled_law(const BetweenRecordings& between) {
  using B = BetweenRecordings;
  static constexpr Member law[]{
      member<&B::kind>("kind", "`series`, `viscoelastic` or `constant`"), estimates_by_name<&B::parameters>(),
      member<&B::correlation>("correlation", "Matrix by rows"),
      member<&B::nodes>("nodes", "ε of the law at some speeds: `[{v_mps, eps, se, ci95}]`"),
      computed(
          "curve",
          [](const B& b) {
            Values points;
            for (std::size_t k = 0; k < b.curve.size(); ++k) {
              Object point = object_of(b.curve[k]);
              point.emplace_back("prediction95", as_value(b.curve_prediction95[k]));
              points.push_back(std::move(point));
            }
            return points;
          },
          "`[{v_mps, eps, lo95, hi95}]`, with the interval in which one more recording is expected")};
  return object_of(law, &between);
}

/// What is one for all only where groups are not seen to differ.
template <auto Member>
auto if_one(const BetweenRecordings& b) {
  return b.groups.empty() ? std::optional(std::invoke(Member, b)) : std::nullopt;
}

std::optional<ChiSquareTest> shapes_where_tested(const BetweenRecordings& b) {
  return b.shapes.ndf > 0.0 ? std::optional(b.shapes) : std::nullopt;
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
                                member<&D::middle>("middle", "Likewise; the pooled law belongs to it")};
  return all;
}

Description members_of(const GroupRow*) {
  static constexpr Member all[]{member<&GroupRow::name>("name", "The plate or the day"),
                                member<&GroupRow::n>("n", "Recordings"),
                                member<&GroupRow::offset>("offset", "Mean offset from the pooled law"),
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
          "Where ε of one more recording of this group (of single recordings: drop) is expected to be measured; "
          "`null`: there is one in each")};
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

Description members_of(const BetweenRecordings*) {
  using B = BetweenRecordings;
  static constexpr Member all[]{
      member<&B::n_recordings>("n_recordings", "Recordings"),
      member<&B::n_used>("n_used", "Those with a law of their own, outliers among them"),
      member<&B::n_samples>("n_samples", "Their samples"),
      where_ok<&B::v_mps>("v_mps", "The reference speed"),
      where_ok<if_one<&B::eps>>(
          "eps",
          "ε of the pooled law there, an estimate whose error includes what differs between recordings, in the "
          "middle of the campaign; `null` where `groups` has some"),
      where_ok<if_one<&B::prediction95>>(
          "prediction95",
          "Where ε of one more recording is expected to be measured, with such errors as the others have; likewise"),
      member<&B::groups>("groups", "ε of each where plates, or a few recordings, differ; else empty; see below"),
      where_ok<&B::tau>(
          "tau",
          "`value`, `ci95`: standard deviation of ε between recordings, of one plate and day where these have "
          "one, beyond the recordings' own errors; `ci95` by profile likelihood"),
      where_ok<&B::heterogeneity>("heterogeneity",
                                  "`chi2`, `ndf`, `p_value`: whether the recordings (outliers too) differ at all"),
      where_ok<shapes_where_tested>(
          "shapes", "The same: whether their curves differ by more than a constant (`null`: one speed)"),
      member<&B::drift>("drift", "`null`, or ε over the campaign, see below"),
      where_ok<if_one<pooled_law>>(
          "law",
          "`kind`, `parameters` and an estimate of each, `correlation`, `nodes`, `curve` as of a fit; `curve` "
          "with `prediction95`; `null` where `groups` has some"),
      member<&B::plates>("plates", "Groups by plate, with the drift taken out"),
      member<&B::days>("days", "Groups by day, with the plates taken out")};
  return all;
}

Description members_of(const GroupLaw*) {
  using G = GroupLaw;
  static constexpr Member all[]{
      member<&G::name>("name", "The plate or the recording"), member<&G::n>("n", "Samples fitted"),
      member<&G::n_units>("n_units", "Drops or recordings, see `unit`"),
      member<&G::nodes>("nodes", "ε of the law at speeds that all groups share"), estimates_by_name<&G::parameters>()};
  return all;
}

Description members_of(const GroupDifference*) {
  using D = GroupDifference;
  static constexpr Member all[]{
      member<&D::reference>("reference", "A group"),
      member<&D::group>("group", "Another; all is of it less the reference"),
      member<&D::offset>("offset", "Estimate of the difference of ε, as a constant at all speeds"),
      member<&D::detectable>("detectable", "A difference that such data show in four of five experiments"),
      member<&D::p_value>(
          "p_value",
          "Of so large an offset by chance, if the groups differ as their units do; times the number of pairs; "
          "`null`: one unit in each"),
      member<&D::nodes>("nodes", "Differences of ε at the nodes, as of a law"),
      estimates_by_name<&D::parameters>()};
  return all;
}

Description members_of(const GroupDifferences*) {
  using D = GroupDifferences;
  static constexpr Member all[]{
      computed(
          "unit", [](const D& d) { return to_string(d.unit); },
          "By what differs within a group differences are judged: `recordings` where a group has several, else "
          "`drops`"),
      member<&D::ndf>("ndf",
                      "Degrees of freedom of Student's t: units less groups; 0: not known, errors are those of "
                      "independent samples"),
      member<&D::deviation>("deviation", "Standard deviation of ε between units of a group, beyond the scatter"),
      member<&D::groups>("groups", "The law of each, see below"), member<&D::rows>("rows", "Every pair, see below")};
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
