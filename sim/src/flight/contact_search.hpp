// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/flight.hpp"
#include "envelope/leaf_search.hpp"
#include "envelope/pole.hpp"

namespace bouncelab::sim {

/// The search for the first contact of one flight (the method: find_first_contact). Path is the centre's: Parabola or
/// DraggedPath.
///
/// It goes in steps, each of which ends by asking for the memory that the next reads. Of a large envelope that takes as
/// long as all the computing; where the searches of several balls take turns, none waits.
template <class Path>
class ContactSearch {
 public:
  /// First step: where the pole is when the ball comes down. @param envelope  must outlive the search
  ContactSearch(const Ball& ball, const Envelope& envelope, const BallState& start, Path path,
                std::optional<std::int64_t> left);
  /// Second step, to be repeated until it is done: the leaf around the pole. @return whether it is found
  bool find_leaf();
  /// Third step: the contact, most often in that leaf. @throws Error where there is none
  FirstContact find_contact();

 private:
  /// The sites of a leaf that are examined: all of its list, until most of it is ruled out. Longer lists than fit are
  /// not narrowed; leaves hold so many only where as many asperities meet in a point.
  struct LeafSites {
    static constexpr std::size_t kMostNarrowed = 32;
    std::span<const std::uint16_t> list;
    bool is_narrow = false;
    std::array<std::uint16_t, kMostNarrowed> few;
    std::array<double, kMostNarrowed> gap_m, slope_mps;
  };
  struct Candidate {
    double step_s, gap_m, slope_mps;
    const Envelope::Site* site;  ///< nullptr: the smooth sphere
  };
  struct Found {
    double t_s;
    const Envelope::Site* site;  ///< nullptr: the smooth sphere
  };

  double time_of_unhindered_rise() const;
  double skip_above(double elevation, double t) const;
  void go_down_to_envelope();
  std::optional<Found> find_in_leaf(double t_exit) const;
  void leave_leaf(double t_exit);
  FirstContact contact_of(const Found& found) const;

  Candidate nearest(LeafSites& listed, double t, const Pole::Instant& pole) const;
  void narrow(LeafSites& listed, const Candidate& first, double leaf_left_s) const;
  bool is_open_until(double step_s, double gap_m, double slope_mps) const;
  Candidate judge(const Envelope::Site* site, double gap_m, double slope_mps, double t) const;
  std::int64_t index_of(const Envelope::Site* site) const;

  double radius_m_;
  const Envelope* envelope_;
  BallState start_;
  Path path_;
  Pole pole_;
  double bend_mps2_;  ///< bound of -gap'' for asperities
  std::optional<std::int64_t> left_;

  double t_ = 0.0;  ///< until here there is no contact
  Pole here_;       ///< with its clock at t_
  std::optional<LeafSearch> leaf_search_;
  Envelope::Leaf leaf_{};  ///< around the pole
};

}  // namespace bouncelab::sim
