// SPDX-License-Identifier: GPL-3.0-or-later
// What the results of many recordings, of samples and studies are called and what they are, key by key (docs/formats.md
// is made of these texts).
#include "bouncelab/fit/between_recordings.hpp"
#include "bouncelab/fit/calibration.hpp"
#include "bouncelab/fit/group_differences.hpp"
#include "bouncelab/fit/restitution.hpp"
#include "results/parts.hpp"

namespace bouncelab::fit {

namespace {

Object pooled_law(const BetweenRecordings& between) {
  using B = BetweenRecordings;
  static const Description law{result("kind", &B::kind, "As of a law"), estimates_by_name<B>(),
                               result("correlation", &B::correlation, "As of a law"),
                               result("nodes", &B::nodes, "As of a law"),
                               result<B>(
                                   "curve",
                                   [](const B& b) {
                                     Values points;
                                     for (std::size_t k = 0; k < b.curve.size(); ++k) {
                                       Object point = object_of(members_of(&b.curve[k]), &b.curve[k]);
                                       point.emplace_back("prediction95", as_value(b.curve_prediction95[k]));
                                       points.push_back(std::move(point));
                                     }
                                     return points;
                                   },
                                   "As of a law, with the interval in which one more recording is expected")};
  return object_of(law, &between);
}

}  // namespace

const Description& members_of(const StandardDeviation*) {
  static const Description all{result("value", &StandardDeviation::value, "Standard deviation"),
                               result("ci95", &StandardDeviation::ci95, "By profile likelihood")};
  return all;
}

const Description& members_of(const ChiSquareTest*) {
  static const Description all{result("chi2", &ChiSquareTest::chi2, "χ²"),
                               result("ndf", &ChiSquareTest::ndf, "Its degrees of freedom"),
                               result("p_value", &ChiSquareTest::p_value, "Its p")};
  return all;
}

const Description& members_of(const Drift*) {
  using D = Drift;
  static const Description all{result<D>(
                                   "per", [](const D& d) { return d.by_date ? "day" : "recording"; },
                                   "`day`; `recording` where fewer than half have a date: in their order"),
                               result("slope", &D::slope, "An estimate"),
                               result("p_value", &D::p_value, "p"),
                               result("begin", &D::begin, "Days since 1970-01-01, or the number of the recording"),
                               result("end", &D::end, "Likewise"),
                               result("middle", &D::middle, "Likewise; the pooled law belongs to it")};
  return all;
}

const Description& members_of(const GroupRow*) {
  static const Description all{result("name", &GroupRow::name, "The plate or the day"),
                               result("n", &GroupRow::n, "Recordings"),
                               result("offset", &GroupRow::offset, "Mean offset from the pooled law"),
                               result("se", &GroupRow::se, "Its standard error")};
  return all;
}

const Description& members_of(const Grouping*) {
  static const Description all{
      result("effect", &Grouping::effect,
             "`none` (`notes` say why), `fixed` (2 to 4 plates: a constant for each) or `random` (5 or more, and 5 "
             "recordings more than groups)"),
      result("deviation", &Grouping::deviation, "`null`, or as `tau`"),
      result("rows", &Grouping::rows, "`name`, `n`, `offset`, `se`")};
  return all;
}

const Description& members_of(const BetweenRecordings*) {
  using B = BetweenRecordings;
  static const Description all{
      result("notes", &B::notes, "What could not be had"),
      result("n_recordings", &B::n_recordings, "Recordings"),
      result("n_used", &B::n_used, "Those with a law of their own, outliers among them"),
      result("n_samples", &B::n_samples, "Their samples"),
      where_ok<B>("v_mps", &B::v_mps, "The reference speed"),
      where_ok<B>("eps", &B::eps,
                  "ε of the pooled law there, an estimate whose error includes what differs between recordings, in the "
                  "middle of the campaign"),
      where_ok<B>("prediction95", &B::prediction95, "Where one more recording is expected"),
      where_ok<B>("tau", &B::tau,
                  "`value`, `ci95`: standard deviation of ε between recordings, of one plate and day where these have "
                  "one, beyond the recordings' own errors; `ci95` by profile likelihood"),
      where_ok<B>("heterogeneity", &B::heterogeneity,
                  "`chi2`, `ndf`, `p_value`: whether the recordings (outliers too) differ at all"),
      where_ok<B>(
          "shapes", [](const B& b) { return b.shapes.ndf > 0.0 ? std::optional(b.shapes) : std::nullopt; },
          "The same: whether their curves differ by more than a constant (`null`: one speed)"),
      result("drift", &B::drift, "`null`, or ε over the campaign, see below"),
      where_ok<B>("law", pooled_law,
                  "`kind`, `parameters` and an estimate of each, `correlation`, `nodes`, `curve` as of a fit; `curve` "
                  "with `prediction95`"),
      result("plates", &B::plates, "Groups by plate, with the drift taken out"),
      result("days", &B::days, "Groups by day, with the plates taken out")};
  return all;
}

const Description& members_of(const GroupLaw*) {
  using G = GroupLaw;
  static const Description all{
      result("name", &G::name, "The plate or the recording"), result("n", &G::n, "Samples fitted"),
      result("n_units", &G::n_units, "Drops or recordings, see `unit`"),
      result("nodes", &G::nodes, "As of a law, at speeds that all groups share"), estimates_by_name<G>()};
  return all;
}

const Description& members_of(const GroupDifference*) {
  using D = GroupDifference;
  static const Description all{
      result("reference", &D::reference, "A group"),
      result("group", &D::group, "Another; all is of it less the reference"),
      result("offset", &D::offset, "Estimate of the difference of ε, as a constant at all speeds"),
      result("detectable", &D::detectable, "A difference that such data show in four of five experiments"),
      result("p_value", &D::p_value,
             "Of so large an offset by chance, if the groups differ as their units do; times the number of pairs; "
             "`null`: one unit in each"),
      result("nodes", &D::nodes, "Differences of ε at the nodes, as of a law"),
      estimates_by_name<D>()};
  return all;
}

const Description& members_of(const GroupDifferences*) {
  using D = GroupDifferences;
  static const Description all{
      result("message", &D::message, "Why there are no `rows`"),
      result<D>(
          "unit", [](const D& d) { return to_string(d.unit); },
          "By what differs within a group differences are judged: `recordings` where a group has several, else "
          "`drops`"),
      result("ndf", &D::ndf,
             "Degrees of freedom of Student's t: units less groups; 0: not known, errors are those of "
             "independent samples"),
      result("deviation", &D::deviation, "Standard deviation of ε between units of a group, beyond the scatter"),
      result("groups", &D::groups, "The law of each, see below"),
      result("rows", &D::rows, "Every pair, see below")};
  return all;
}

const Description& members_of(const RestitutionCounts*) {
  using C = RestitutionCounts;
  static const Description all{result("n_onsets", &C::n_onsets, "Impacts read"),
                               result("n_drops", &C::n_drops, "Drops"),
                               result("n_samples", &C::n_samples, "Coefficients of restitution"),
                               result("n_flagged", &C::n_flagged, "Of these with a flag: they stay out of the fit"),
                               result("eps_median", &C::eps_median, "Of the others"),
                               result("n_heights_contradicted", &C::n_heights_contradicted,
                                      "Drops whose flights contradict `--drop-height`: their first impact is left out"),
                               result("height_suggested_m", &C::height_suggested_m,
                                      "Height of the fall that these suggest, their median; `null`: none"),
                               result<C>(
                                   "breaks",
                                   [](const C& c) {
                                     Object breaks;
                                     for (const auto& [reason, n] : c.breaks)
                                       breaks.emplace_back(name_of(reason), value_of(n));
                                     return breaks;
                                   },
                                   "Places where the chain of a drop is broken: reason → number")};
  return all;
}

const Description& members_of(const IntervalPrediction*) {
  using P = IntervalPrediction;
  static const Description all{result("impact", &P::impact, "That the interval follows"),
                               result("found_s", &P::measured_s, "As measured"),
                               result("expected_s", &P::predicted_s, "By the law; `null` without one"),
                               result("sigma_s", &P::sigma_s, "Standard error of the measured one")};
  return all;
}

const Description& members_of(const CalibrationRow*) {
  using R = CalibrationRow;
  static const Description all{
      result("name", &R::name, "The quantity"),
      result("truth", &R::truth, "Its true value"),
      result("bound_independent", &R::bound_independent, "Cramér-Rao bound of its error, if samples were independent"),
      result("spread", &R::spread, "Standard deviation of the estimates"),
      result("mean_se", &R::mean_se, "Mean of the standard errors stated"),
      result("pull_mean", &R::pull_mean, "Mean of (estimate - truth) / se"),
      result("pull_sd", &R::pull_sd, "Its standard deviation"),
      result("coverage68", &R::coverage68, "Share of the 68 % intervals that hold the truth"),
      result("coverage95", &R::coverage95, "Of the 95 % intervals")};
  return all;
}

const Description& members_of(const CalibrationResult*) {
  static const Description all{result("rows", &CalibrationResult::rows, "A row for each quantity"),
                               result("n_failed", &CalibrationResult::n_failed, "Seeds whose fit did not converge")};
  return all;
}

}  // namespace bouncelab::fit
