// SPDX-License-Identifier: GPL-3.0-or-later
// The mixed linear model over recordings: closed forms, a dense twin, and whether its errors hold over many seeds.
#include "bouncelab/fit/between_recordings.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "between/offset_model.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/random.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "support/statistics.hpp"

namespace bouncelab::fit {
namespace {

/// A campaign whose truth is known, drawn at the level of the recordings' own values.
struct Campaign {
  std::size_t n = 40;
  double tau = 3e-4, sd_plate = 0.0, sd_day = 0.0;
  double slope_per_day = 0.0;
  std::size_t n_days = 20, n_plates = 1;
  double least_error = 1e-4, greatest_error = 3e-4;  ///< of a value at a node
  std::uint64_t seed = 1;
  bool in_turn = true;  ///< false: all of a plate, and then all of the next
};

constexpr double kSpeeds_mps[] = {0.25, 0.63, 1.25};
constexpr double kReference_mps = 0.63;

std::vector<CampaignRecording> drawn(const Campaign& campaign) {
  const RestitutionLaw law = SeriesLaw{};
  Random random(campaign.seed, RandomStream::test, 1);
  std::vector<double> plates, days;
  for (std::size_t k = 0; k < campaign.n_plates; ++k) plates.push_back(campaign.sd_plate * random.normal());
  for (std::size_t k = 0; k < campaign.n_days; ++k) days.push_back(campaign.sd_day * random.normal());
  std::vector<CampaignRecording> recordings;
  for (std::size_t k = 0; k < campaign.n; ++k) {
    CampaignRecording r;
    const std::size_t day = k * campaign.n_days / campaign.n,
                      plate = campaign.in_turn ? k % campaign.n_plates : k * campaign.n_plates / campaign.n;
    r.summary.recording = "r" + std::to_string(k);
    r.summary.status = FitStatus::ok;
    r.summary.n = 100;
    const double t =
        (static_cast<double>(k) + 0.5) * static_cast<double>(campaign.n_days) / static_cast<double>(campaign.n);
    const double middle = 0.5 * static_cast<double>(campaign.n_days);
    const double offset =
        campaign.tau * random.normal() + plates[plate] + days[day] + campaign.slope_per_day * (t - middle);
    const double se = random.uniform(campaign.least_error, campaign.greatest_error);
    for (const double v_mps : kSpeeds_mps)
      r.summary.nodes.push_back({v_mps, normal_estimate(restitution(law, v_mps) + offset + se * random.normal(), se)});
    r.origin.plate = campaign.n_plates > 1 ? "plate " + std::to_string(plate) : "";
    r.origin.date = RecordingDate{20000.0 + t, 20000 + static_cast<std::int64_t>(day)};
    recordings.push_back(r);
  }
  return recordings;
}

double truth_at(double v_mps) { return restitution(SeriesLaw{}, v_mps); }

bool contains(const Interval& interval, double value) { return interval.lo <= value && value <= interval.hi; }

/// All recordings at the reference speed.
Design design_of(const std::vector<CampaignRecording>& recordings) {
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < recordings.size(); ++k) used.push_back(k);
  return make_design(recordings, used, times_of(recordings, used), kReference_mps);
}

/// The same with a matrix of all recordings: n x n, as textbooks write it.
struct Dense {
  double minus_two_log_likelihood = 0.0;
  Eigen::VectorXd beta;
  Eigen::MatrixXd covariance;
};

Dense dense(const OffsetData& data, const Deviations& deviations) {
  Eigen::MatrixXd v = data.variance.asDiagonal();
  for (Eigen::Index r = 0; r < data.n(); ++r)
    for (Eigen::Index s = 0; s < data.n(); ++s)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto a = static_cast<std::size_t>(r), b = static_cast<std::size_t>(s);
        const bool shared = k == 0 ? r == s
                                   : data.n_levels[k - 1] > 0 && data.level[k - 1][a] >= 0 &&
                                         data.level[k - 1][a] == data.level[k - 1][b];
        if (shared) v(r, s) += deviations[k] * deviations[k];
      }
  const Eigen::LDLT<Eigen::MatrixXd> weights(v);
  const Eigen::MatrixXd x = data.h();
  const Eigen::VectorXd y = data.m();
  const Eigen::MatrixXd information = x.transpose() * weights.solve(x);
  Dense result;
  result.covariance = information.inverse();
  result.beta = result.covariance * (x.transpose() * weights.solve(y));
  const Eigen::VectorXd residual = y - x * result.beta;
  result.minus_two_log_likelihood = weights.vectorD().array().log().sum() + std::log(information.determinant()) +
                                    residual.dot(weights.solve(residual));
  return result;
}

TEST(OffsetSolution, IsGeneralisedLeastSquaresOfAllValues) {
  Campaign campaign{.n = 36, .sd_plate = 2e-4, .sd_day = 2e-4, .slope_per_day = 3e-5, .n_days = 9, .n_plates = 6};
  std::vector<CampaignRecording> recordings = drawn(campaign);
  recordings[7].origin.plate.clear();  // not known
  const Design design = design_of(recordings);
  ASSERT_EQ(design.plates.effect, GroupEffect::random);
  ASSERT_EQ(design.days.effect, GroupEffect::random);
  for (const Deviations& deviations : {Deviations{3e-4, 2e-4, 1e-4}, Deviations{0.0, 0.0, 0.0},
                                       Deviations{1e-4, 0.0, 3e-4}, Deviations{2e-4, 5e-4, 0.0}}) {
    const OffsetSolution blocks(design.data, deviations);
    const Dense twin = dense(design.data, deviations);
    // eps to 1e-12: far below any error, and what is left of 16 digits after the inverses
    EXPECT_LT((blocks.beta() - twin.beta).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((blocks.covariance() - twin.covariance).norm(), 1e-9 * twin.covariance.norm());
    EXPECT_NEAR(blocks.minus_two_log_likelihood(), twin.minus_two_log_likelihood, 1e-6);
  }
}

TEST(OffsetSolution, PredictsARecordingWithoutItAsAFitWithoutItDoes) {
  const Campaign campaign{.n = 36, .sd_plate = 2e-4, .sd_day = 2e-4, .n_days = 9, .n_plates = 6};
  const Design design = design_of(drawn(campaign));
  const Deviations deviations{3e-4, 2e-4, 1e-4};
  const OffsetSolution all(design.data, deviations);
  for (const Eigen::Index left_out : {Eigen::Index{0}, Eigen::Index{13}, Eigen::Index{35}}) {
    std::vector<Eigen::Index> others;
    for (Eigen::Index r = 0; r < design.data.n(); ++r)
      if (r != left_out) others.push_back(r);
    const OffsetData data = rows_of(design.data, others);
    const auto k = static_cast<std::size_t>(left_out);
    const OffsetSolution::Residual by_fit =
        OffsetSolution(data, deviations)
            .of_another(design.data.h().row(left_out), design.data.m()[left_out], design.data.variance[left_out],
                        {design.data.level[0][k], design.data.level[1][k]});
    const OffsetSolution::Residual by_formula = all.without(left_out);
    EXPECT_NEAR(by_formula.value, by_fit.value, 1e-9 * by_fit.se);
    EXPECT_NEAR(by_formula.se, by_fit.se, 1e-9 * by_fit.se);
  }
}

/// Recordings of one speed with equal errors: an analysis of variance.
std::vector<CampaignRecording> of_one_speed(const std::vector<double>& eps, double se) {
  std::vector<CampaignRecording> recordings;
  for (const double value : eps) {
    CampaignRecording r;
    r.summary.status = FitStatus::ok;
    r.summary.recording = "r" + std::to_string(recordings.size());
    r.summary.nodes = {{0.5, normal_estimate(value, se)}};
    r.origin.date = RecordingDate{20000.5, 20000};  // all of one day: no drift
    recordings.push_back(r);
  }
  return recordings;
}

TEST(CompareCampaign, OfEqualErrorsIsAnAnalysisOfVariance) {
  const std::vector<double> eps{0.9712, 0.9708, 0.9721, 0.9715, 0.9709, 0.9718, 0.9711};
  const double se = 1.5e-4, n = static_cast<double>(eps.size());
  double mean = 0.0, variance = 0.0;
  for (const double e : eps) mean += e / n;
  for (const double e : eps) variance += (e - mean) * (e - mean) / (n - 1.0);
  const BetweenRecordings found = compare_campaign(of_one_speed(eps, se));
  ASSERT_EQ(found.status, FitStatus::ok);
  ASSERT_EQ(found.nodes.size(), 1u);
  EXPECT_EQ(found.nodes[0].eps.value, found.eps.value);
  EXPECT_NEAR(found.eps.value, mean, 1e-12);
  // the search for tau stops at 1e-4 of its bracket, of at most twice its value
  EXPECT_NEAR(found.tau.value, std::sqrt(variance - se * se), 3e-4 * found.tau.value);
  EXPECT_NEAR(*found.eps.se, std::sqrt(variance / n), 3e-4 * *found.eps.se);
  // Student's t of six degrees of freedom, 97.5 %
  EXPECT_NEAR((found.eps.ci95->hi - mean) / *found.eps.se, 2.446912, 0.03);
  EXPECT_NEAR(found.heterogeneity.chi2, (n - 1.0) * variance / (se * se), 1e-6);
  EXPECT_EQ(found.heterogeneity.ndf, n - 1.0);
  EXPECT_FALSE(found.drift);
  EXPECT_EQ(found.n_outliers, 0u);
  // the restricted likelihood of an analysis of variance: -2 ln L = (n - 1) (ln s + variance/s), s = tau^2 + se^2
  const auto minus_two_ln = [&](double tau) {
    const double s = tau * tau + se * se;
    return (n - 1.0) * (std::log(s) + variance / s);
  };
  // the square of Student's t; its ends are sought to 2e-3 of themselves
  for (const double end : {found.tau.ci95.lo, found.tau.ci95.hi})
    EXPECT_NEAR(minus_two_ln(end) - minus_two_ln(found.tau.value), 2.446912 * 2.446912, 0.05);
}

TEST(CompareCampaign, WithoutDifferencesIsTheWeightedMean) {
  std::vector<CampaignRecording> recordings = of_one_speed({0.9712, 0.97125, 0.97118, 0.97123, 0.97119}, 1e-4);
  for (std::size_t k = 0; k < recordings.size(); ++k)
    recordings[k].summary.nodes[0].eps.se = 1e-4 * std::sqrt(1.0 + static_cast<double>(k));
  double sum = 0.0, weights = 0.0;
  for (const CampaignRecording& r : recordings) {
    const Estimate& eps = r.summary.nodes[0].eps;
    sum += eps.value / (*eps.se * *eps.se);
    weights += 1.0 / (*eps.se * *eps.se);
  }
  const BetweenRecordings found = compare_campaign(recordings);
  EXPECT_EQ(found.tau.value, 0.0);
  EXPECT_EQ(found.tau.ci95.lo, 0.0);
  EXPECT_NEAR(found.eps.value, sum / weights, 1e-12);
  EXPECT_NEAR(*found.eps.se, 1.0 / std::sqrt(weights), 1e-12);
  EXPECT_GT(found.heterogeneity.p_value, 0.9);
}

/// Of how many campaigns the 95 % intervals hold the truth, and in how many what is not there is claimed.
struct Counts {
  double eps = 0.0, drift = 0.0, tau = 0.0, prediction = 0.0, false_alarms = 0.0, false_drifts = 0.0;
};

Counts counts_of(const Campaign& campaign, std::size_t n_seeds) {
  std::vector<BetweenRecordings> all(n_seeds);
  parallel_for(n_seeds, 0, [&](std::size_t k) {
    Campaign one = campaign;
    one.seed = 1000 + k;
    one.n = campaign.n + 1;
    std::vector<CampaignRecording> recordings = drawn(one);
    // one more recording, in the middle of the campaign, which the others are to predict
    recordings.erase(recordings.begin() + static_cast<std::ptrdiff_t>(one.n / 2));
    all[k] = compare_campaign(recordings);
  });
  Counts n;
  for (std::size_t k = 0; k < n_seeds; ++k) {
    const BetweenRecordings& found = all[k];
    Random random(1000 + k, RandomStream::test, 2);
    const double next = truth_at(kReference_mps) + campaign.tau * random.normal() +
                        campaign.sd_plate * random.normal() + campaign.sd_day * random.normal();
    n.eps += contains(*found.eps.ci95, truth_at(kReference_mps));
    n.drift += found.drift && contains(*found.drift->slope.ci95, campaign.slope_per_day);
    n.false_drifts += campaign.slope_per_day == 0.0 && found.drift && found.drift->p_value < 0.05;
    n.tau += contains(found.tau.ci95, campaign.tau);
    n.prediction += contains(found.prediction95, next);
    n.false_alarms += found.n_outliers > 0;
  }
  return n;
}

TEST(CompareCampaign, CoversTheTruth) {
  // with few recordings; with unequal errors and a drift; with plates and days
  for (const Campaign& campaign :
       {Campaign{.n = 12, .n_days = 12},
        Campaign{.n = 40, .tau = 2e-4, .slope_per_day = 4e-5, .least_error = 3e-5, .greatest_error = 1e-3},
        Campaign{.n = 60, .sd_plate = 3e-4, .sd_day = 3e-4, .n_days = 10, .n_plates = 8}}) {
    SCOPED_TRACE(campaign.n);
    const auto n_seeds = test::repetitions<std::size_t>(40, 200);
    const Counts n = counts_of(campaign, n_seeds);
    const auto all = static_cast<double>(n_seeds);
    for (const double held : {n.eps, n.drift, n.tau, n.prediction}) EXPECT_GE(held, test::fewest_of(all, 0.95));
    EXPECT_TRUE(n_seeds < 200 || n.eps < all) << "200 of 200 is an interval that is too wide";
    EXPECT_LE(n.false_drifts, test::most_of(all, 0.05));
    EXPECT_LE(n.false_alarms, test::most_of(all, 0.05));
  }
}

TEST(CompareCampaign, OfPlatesThatDifferEachHasItsOwnEpsAndTheNextRecordingOfItIsForetold) {
  // few recordings of two plates; many, with a drift; with days; of so many plates that they are a random effect
  for (const Campaign& campaign : {Campaign{.n = 10, .sd_plate = 5e-3, .n_days = 10, .n_plates = 2},
                                   Campaign{.n = 40, .sd_plate = 5e-3, .slope_per_day = 4e-5, .n_plates = 2},
                                   Campaign{.n = 60, .sd_plate = 5e-3, .sd_day = 3e-4, .n_days = 12, .n_plates = 3},
                                   Campaign{.n = 48, .sd_plate = 5e-3, .n_days = 24, .n_plates = 8}}) {
    SCOPED_TRACE(campaign.n);
    const auto n_seeds = test::repetitions<std::size_t>(30, 300);
    std::vector<std::array<double, 3>> held(n_seeds);  // of all plates: eps, next recording, groups stated
    parallel_for(n_seeds, 0, [&](std::size_t k) {
      Campaign one = campaign;
      one.seed = 5000 + k;
      one.n += campaign.n_plates;
      std::vector<CampaignRecording> recordings = drawn(one);
      // one of each plate, in the middle of the campaign
      const auto first = recordings.begin() + static_cast<std::ptrdiff_t>(campaign.n / 2);
      const std::vector<CampaignRecording> next(first, first + static_cast<std::ptrdiff_t>(campaign.n_plates));
      recordings.erase(first, first + static_cast<std::ptrdiff_t>(campaign.n_plates));
      const BetweenRecordings found = compare_campaign(recordings);
      held[k][2] = found.groups_differ();
      if (!found.groups_differ()) return;
      const std::vector<GroupRestitution>& groups = found.differences->groups;
      ASSERT_EQ(groups.size(), campaign.n_plates);
      Random random(one.seed, RandomStream::test, 1);
      std::map<std::string, double> plate_of;  // in the order in which drawn() draws them
      const std::vector<CampaignRecording> all = drawn(one);
      for (std::size_t p = 0; p < campaign.n_plates; ++p)
        plate_of[all[p].origin.plate] = campaign.sd_plate * random.normal();
      for (const GroupRestitution& group : groups) {
        held[k][0] += contains(*group.eps.ci95, truth_at(kReference_mps) + plate_of.at(group.name));
        for (const CampaignRecording& r : next)
          if (r.origin.plate == group.name)
            held[k][1] += contains(group.prediction95.value(), r.summary.nodes[1].eps.value);
      }
    });
    double n_eps = 0.0, n_next = 0.0, n_stated = 0.0;
    for (const auto& one : held) n_eps += one[0], n_next += one[1], n_stated += one[2];
    // two plates of 5e-3 are, once in 15, nearer than what is seen
    EXPECT_GE(n_stated, test::fewest_of(static_cast<double>(n_seeds), 0.9));
    const double n = n_stated * static_cast<double>(campaign.n_plates);
    for (const double good : {n_eps, n_next}) EXPECT_GE(good, test::fewest_of(n, 0.95));
    EXPECT_LE(n_next, n_seeds < 300 ? n : 0.99 * n) << "an interval that is too wide";
  }
}

TEST(CompareCampaign, OfPlatesOneAfterTheOtherKnowsThatADriftMovesThemApart) {
  // few recordings of two plates; with a drift; with days; of so many plates that they are a random effect
  for (const Campaign& campaign :
       {Campaign{.n = 12, .n_days = 12, .n_plates = 2, .in_turn = false},
        Campaign{.n = 20, .slope_per_day = 1e-4, .n_days = 20, .n_plates = 2, .in_turn = false},
        Campaign{.n = 60, .sd_day = 3e-4, .n_days = 12, .n_plates = 3, .in_turn = false},
        Campaign{.n = 48, .n_days = 24, .n_plates = 8, .in_turn = false}}) {
    SCOPED_TRACE(campaign.n);
    const auto n_seeds = test::repetitions<std::size_t>(40, 300);
    std::vector<std::array<double, 3>> found(n_seeds);  // differences held at the middle and at one end, differ
    parallel_for(n_seeds, 0, [&](std::size_t k) {
      Campaign one = campaign;
      one.seed = 9000 + k;
      const GroupDifferences differences = compare_campaign(drawn(one)).differences.value();
      found[k][2] = differences.differ;
      if (campaign.n_plates > kMostGroups) return;
      const GroupDifference& row = differences.rows.at(0);
      found[k][0] = contains(*row.eps.ci95, 0.0);
      found[k][1] = contains(*row.nodes.at(0).eps.ci95, 0.0);
    });
    std::array<double, 3> n{};
    for (const auto& one : found)
      for (std::size_t i = 0; i < 3; ++i) n[i] += one[i];
    const auto all = static_cast<double>(n_seeds);
    EXPECT_LE(n[2], test::most_of(all, 0.05));
    if (campaign.n_plates > kMostGroups) continue;
    EXPECT_GE(n[0], test::fewest_of(all, 0.95));
    EXPECT_GE(n[1], test::fewest_of(all, 0.95));
  }
}

TEST(CompareCampaign, SaysThatPlatesScatterUnequally) {
  const auto n_seeds = test::repetitions<std::size_t>(100, 1000);
  std::array<double, 2> n{};
  for (std::size_t k = 0; k < n_seeds; ++k)
    for (const bool is_wide : {false, true}) {
      std::vector<CampaignRecording> recordings =
          drawn({.n = 16, .n_days = 16, .n_plates = 2, .least_error = 2e-5, .greatest_error = 5e-5, .seed = 300 + k});
      Random random(300 + k, RandomStream::test, 5);
      for (CampaignRecording& r : recordings) {
        const double offset = 3e-3 * random.normal();  // ten times tau
        if (is_wide && r.origin.plate == "plate 1")
          for (NodeEstimate& node : r.summary.nodes) node.eps.value += offset;
      }
      const BetweenRecordings found = compare_campaign(recordings);
      n[is_wide] += found.unequal_scatter.has_value();
      EXPECT_TRUE(!is_wide || !found.unequal_scatter || found.unequal_scatter->widest == "plate 1");
    }
  EXPECT_LE(n[0], test::most_of(static_cast<double>(n_seeds), 0.01));
  EXPECT_GE(n[1], test::fewest_of(static_cast<double>(n_seeds), 0.95));
}

TEST(CompareCampaign, SaysThatPlatesWereMeasuredOneAfterTheOther) {
  const auto note_of = [](const Campaign& campaign, bool is_dated) {
    std::vector<CampaignRecording> recordings = drawn(campaign);
    for (CampaignRecording& r : recordings)
      if (!is_dated) r.origin.date.reset();
    for (const Note& note : compare_campaign(recordings).notes)
      if (note.kind == NoteKind::plates_are_times) return note.subject;
    return std::string();
  };
  for (const bool is_dated : {true, false}) {
    EXPECT_EQ(note_of({.n = 12, .n_days = 12, .n_plates = 3, .in_turn = false}, is_dated), "plate 0 and plate 2");
    EXPECT_EQ(note_of({.n = 24, .n_days = 24, .n_plates = 8, .in_turn = false}, is_dated), "the plates");
    for (const std::size_t n_plates : {2, 3, 8}) EXPECT_EQ(note_of({.n = 24, .n_plates = n_plates}, is_dated), "");
  }
  // a day each: they are the drift, and no difference is stated
  EXPECT_EQ(note_of({.n = 12, .n_days = 2, .n_plates = 2, .in_turn = false}, true), "plate 0 and plate 1");
}

TEST(CompareCampaign, OfHundredsOfRecordingsHasNoBiasThatTheirMeanShows) {
  // two drops of 30 bounces each: a hard ball, a soft one, and one that yields, eps ~ v^(-1/4)
  TableLaw yields;
  for (double v_mps = 0.1; v_mps < 2.0; v_mps += 0.01) {
    yields.v_mps.push_back(v_mps);
    yields.eps.push_back(0.6 * std::pow(v_mps, -0.25));
  }
  for (const RestitutionLaw& law :
       {RestitutionLaw(SeriesLaw{}), RestitutionLaw(ViscoelasticLaw{0.3}), RestitutionLaw(yields)}) {
    std::vector<CampaignRecording> recordings(200);
    parallel_for(recordings.size(), 0, [&](std::size_t r) {
      Random random(r, RandomStream::test, 3);
      RestitutionSamples samples;
      for (int k = 0; k < 60; ++k) {
        RestitutionSample s;
        s.recording = "r" + std::to_string(r);
        s.drop = k / 30;
        s.impact = 1 + k % 30;
        s.v_mps = 1.4 * std::pow(0.15, (k % 30) / 29.0);
        s.eps = restitution(law, s.v_mps) + 1e-3 / s.v_mps * (random.exponential() - random.exponential());
        samples.push_back(s);
      }
      recordings[r].summary = summarize_recording(samples);
    });
    const BetweenRecordings found = compare_campaign(recordings);
    ASSERT_GE(found.nodes.size(), 7u);
    for (const CampaignNode& node : found.nodes) {
      const double variance = 2e-6 / (node.v_mps * node.v_mps);
      EXPECT_NEAR(node.eps.value, std::hypot(restitution(law, node.v_mps), std::sqrt(variance)), 3.0 * *node.eps.se)
          << node.v_mps;
    }
  }
}

TEST(CompareCampaign, NamesOutliersAndLeavesThemOut) {
  const Campaign campaign{.n = 60, .n_days = 60};
  std::vector<CampaignRecording> recordings = drawn(campaign);
  const BetweenRecordings before = compare_campaign(recordings);
  ASSERT_EQ(before.n_outliers, 0u);
  for (const std::size_t bad : {std::size_t{11}, std::size_t{40}})
    for (NodeEstimate& node : recordings[bad].summary.nodes) node.eps.value += 4e-3;  // thirteen tau
  recordings[0].summary.n_left_out = 1;
  recordings[0].summary.n_outliers = 2;  // samples
  recordings[1].summary.recording = "=1+1";
  const BetweenRecordings found = compare_campaign(recordings);
  EXPECT_EQ(found.n_outliers, 2u);
  const Table table = to_table(found, recordings);
  EXPECT_EQ(table.integers("n_left_out")->at(0), 1);
  EXPECT_EQ(table.integers("n_outliers")->at(0), 2);
  EXPECT_EQ(table.texts("recording")->at(1), "'=1+1");  // a spreadsheet makes no 2 of it
  EXPECT_TRUE(found.rows[11].is_outlier);
  EXPECT_TRUE(found.rows[40].is_outlier);
  EXPECT_GT(found.rows[40].standardised, 8.0);
  // what two recordings of 60 say themselves
  EXPECT_NEAR(found.tau.value, before.tau.value, 0.15 * before.tau.value);
  EXPECT_NEAR(found.eps.value, before.eps.value, *before.eps.se);
}

TEST(CompareCampaign, OfTooFewSaysHowManyAreNeeded) {
  std::vector<CampaignRecording> recordings = drawn({.n = 5});
  recordings[0].summary.status = recordings[1].summary.status = FitStatus::too_few_samples;
  const BetweenRecordings found = compare_campaign(recordings);
  EXPECT_EQ(found.status, FitStatus::too_few_samples);
  ASSERT_TRUE(found.why);
  EXPECT_EQ(found.why->kind, NoteKind::too_few_recordings);
  EXPECT_EQ(found.why->numbers.at(0), 3.0);
  EXPECT_TRUE(found.rows[0].why_not || found.n_used == 3);
}

TEST(SummarizeRecording, GivesItsOwnEpsWithItsErrors) {
  RestitutionSamples samples;
  const RestitutionLaw law = SeriesLaw{};
  Random random(3, RandomStream::test, 0);
  for (int k = 0; k < 300; ++k) {
    RestitutionSample s;
    s.recording = "a";
    s.drop = k / 60;
    s.v_mps = 0.2 * std::pow(7.0, random.uniform());
    s.eps = restitution(law, s.v_mps) + 5e-4 * (random.exponential() - random.exponential());
    samples.push_back(s);
  }
  samples[5].eps = 0.3;  // a lost bounce
  samples[6].flags.add(Flag::missing_impact);
  const RecordingSummary summary = summarize_recording(samples);
  ASSERT_EQ(summary.status, FitStatus::ok);
  EXPECT_EQ(summary.n, 298u);
  EXPECT_EQ(summary.n_outliers, 1u);
  EXPECT_EQ(summary.n_left_out, 1u);
  EXPECT_EQ(summary.n_drops, 5u);
  // 0.2 to 1.4 m/s but for the twentieths at the ends
  ASSERT_GE(summary.nodes.size(), 8u);
  EXPECT_EQ(summary.nodes.front().v_mps, comparison_speed_mps(-7 + (summary.nodes.size() == 8 ? 1 : 0)));
  for (const NodeEstimate& node : summary.nodes) {
    // four standard errors: once in 16,000 seeds; eps is the root mean square, of a scatter of 7e-4
    EXPECT_NEAR(node.eps.value, truth_at(node.v_mps), 4.0 * *node.eps.se);
    EXPECT_LT(*node.eps.se, 5e-4);
    EXPECT_GT(*node.eps.se, 1e-5);
  }
  samples.resize(7);
  EXPECT_EQ(summarize_recording(samples).status, FitStatus::too_few_samples);
  EXPECT_EQ(summarize_recording(samples).why.value().numbers.at(0), 6.0);
}

}  // namespace
}  // namespace bouncelab::fit
