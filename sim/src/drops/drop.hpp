// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "bouncelab/sim/experiment.hpp"
#include "flight/contact_search.hpp"
#include "flight/dragged_path.hpp"
#include "flight/parabola.hpp"

namespace bouncelab::sim {

/// One drop, an impact after the other; each in the steps of its search, so that drops can take turns.
class Drop {
 public:
  /// @param config, envelope  must outlive the drop
  /// @throws InvalidArgument where the ball starts inside the plate
  Drop(const SimulationConfig& config, const Envelope& envelope, std::int64_t number);

  bool is_over() const { return is_over_; }
  void begin_flight();
  /// @return whether it is found
  bool find_leaf();
  /// To the impact and through it, or to the end of the drop.
  void end_flight();

  DropResult result() &&;

 private:
  using Search = std::variant<ContactSearch<Parabola>, ContactSearch<DraggedPath>>;

  std::optional<DropEnd> end_before(const FirstContact& contact, double t_s) const;
  void collide_at(const FirstContact& contact);

  const SimulationConfig* config_;
  const Envelope* envelope_;
  Vector3 gravity_mps2_;
  std::int64_t number_, n_impacts_ = 0;
  double t_s_ = 0.0;
  BallState state_;
  std::optional<std::int64_t> left_;  ///< what the ball touches
  std::optional<Search> search_;
  DropResult result_;
  bool is_over_ = false;
};

}  // namespace bouncelab::sim
