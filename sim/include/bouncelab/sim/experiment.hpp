// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/description.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/parallel.hpp"
#include "bouncelab/core/restitution_law.hpp"
#include "bouncelab/sim/contact.hpp"
#include "bouncelab/sim/envelope.hpp"
#include "bouncelab/sim/flight.hpp"
#include "bouncelab/sim/surface.hpp"

namespace bouncelab::sim {

/// An experiment: one ball dropped many times on a plate. Defaults: the paper's ball, 40 drops.
/// Frame: origin at the plate's centre, z along its normal, x downhill where it is tilted.
struct SimulationConfig {
  Ball ball;
  RestitutionLaw law = SeriesLaw{};
  ContactModel contact = PaperContact{};
  /// Offsets of the contact averaged over the patch that Hertz' smooth ball would have at the impact's speed on this
  /// material; absent: one asperity bears each impact, as in the paper. docs/physics.md, section 7.
  std::optional<Material> patch_plate;
  double gravity_mps2 = kDefaultGravity_mps2;  ///< > 0
  double tilt_rad = 0.0;                       ///< of the plate, in [0, pi/2)
  /// A drop ends where the ball comes down beyond the edge. Without bounds by default: a rough ball wanders off a plate
  /// of 30 x 20 cm in nine drops of ten before its hundredth bounce.
  std::array<double, 2> plate_size_m{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

  std::optional<Air> air;  ///< slows the flights (drag_per_m); absent: none, as in the paper

  std::int64_t n_drops = 40;        ///< >= 1
  std::int64_t first_drop = 0;      ///< number of the first one; a drop depends on (seed, its number) alone
  double drop_height_min_m = 0.09;  ///< of the ball's lowest point above the plate, drawn uniformly
  double drop_height_max_m = 0.10;
  std::array<double, 2> start_position_m{0.0, 0.0};  ///< of the centre, along the plate
  std::array<double, 2> start_velocity_mps{0.0, 0.0};
  std::array<double, 3> start_spin_radps{0.0, 0.0, 0.0};

  std::int64_t n_impacts_max = 100;  ///< per drop, >= 1
  double min_speed_mps = 0.0;        ///< a drop ends before an impact slower, or while it rises
  double max_time_s = std::numeric_limits<double>::infinity();  ///< from release
  bool with_state = false;                                      ///< keep ImpactState for each impact

  std::uint64_t seed = 1;
  int n_threads = 0;  ///< 0: all cores; results do not depend on it
};

/// @throws InvalidArgument naming the quantity, its value and its range
void validate(const SimulationConfig& config);

/// How drop number `drop` starts: a function of (config, drop).
BallState release(const SimulationConfig& config, std::int64_t drop);

/// Why a drop ended.
enum class DropEnd { impacts_reached, speed_reached, time_reached, left_plate };

struct DropResult {
  Impacts impacts;
  EnergyLedger energy;
  DropEnd end = DropEnd::impacts_reached;
};

/// Drops that are simulated together take turns: while the processor fetches from memory what one needs of the
/// envelope, the others compute. More than this gains nothing.
inline constexpr std::size_t kDropsInTurn = 8;

/// Some drops, by their numbers, on one thread; for callers that let drops stream through memory. A drop does not
/// depend on those beside it.
/// @param config    validated
/// @param envelope  made from config.ball and its surface
/// @return as many as numbers, in their order
/// @throws InvalidArgument where the ball starts inside the plate
std::vector<DropResult> simulate_drops(const SimulationConfig& config, const Envelope& envelope,
                                       std::span<const std::int64_t> numbers);

struct SimulationResult {
  Impacts impacts;  ///< ordered by drop and time
  EnergyLedger energy;
  std::array<std::int64_t, 4> n_ended{};  ///< drops by DropEnd
  std::int64_t n_impacts = 0;
  std::int64_t n_smooth = 0;  ///< impacts of the smooth sphere between the asperities
  std::vector<Note> notes;
};
/// Its counts and energies.
Description members_of(const SimulationResult*);

/// Takes each drop once it is simulated; from one thread at a time, in any order.
/// @param k  its place among the drops of the configuration
using DropSink = std::function<void(std::size_t k, DropResult&& drop)>;

/// The drops of the configuration, in parallel: of each thread no more than kDropsInTurn are held here.
/// @param progress  called with drops done; may throw to stop
/// @throws InvalidArgument as `validate` and `simulate_drops`
void simulate_each(const SimulationConfig& config, const Surface& surface, const DropSink& sink,
                   const ProgressCallback& progress = {});

/// What is counted of drops while their impacts pass by; sums do not depend on the order of add().
class SimulationCounts {
 public:
  /// @param k  the drop's place in the sums
  void add(std::size_t k, const DropResult& drop);
  /// With everything but the impacts.
  SimulationResult result() const;

 private:
  struct DropCounts {
    EnergyLedger energy;
    DropEnd end = DropEnd::impacts_reached;
    std::int64_t n_impacts = 0, n_smooth = 0;
  };
  std::vector<DropCounts> drops_;
};

/// All drops, in parallel; the bytes of the result depend neither on the number of threads nor on which other drops
/// are simulated with them.
/// @param progress  called with drops done; may throw to stop
/// @throws InvalidArgument as `validate` and `simulate_drops`
SimulationResult simulate(const SimulationConfig& config, const Surface& surface,
                          const ProgressCallback& progress = {});

}  // namespace bouncelab::sim
