// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "bouncelab/core/error.hpp"
#include "bouncelab/sim/flight.hpp"
#include "envelope/pole.hpp"
#include "flight/dragged_path.hpp"

namespace bouncelab::sim {
namespace {

/// Clearance of the centre on its parabola.
struct Parabola {
  double y0_m, v0_mps, g_mps2;

  double initial_velocity_mps() const { return v0_mps; }
  /// Bound of the downward acceleration.
  double bend_mps2() const { return g_mps2; }
  double height_m(double t) const { return y0_m + t * (v0_mps - 0.5 * g_mps2 * t); }
  double velocity_mps(double t) const { return v0_mps - g_mps2 * t; }
  /// The last time at which the centre is at `level`; t where it is below already.
  double descent_to(double level_m, double t) const {
    const double y = height_m(t), v = velocity_mps(t);
    if (y <= level_m) return t;
    const double root = std::sqrt(v * v + 2.0 * g_mps2 * (y - level_m));
    return t + (v > 0.0 ? (v + root) / g_mps2 : 2.0 * (y - level_m) / (root - v));
  }
};

/// How long gap + slope s - bend s^2/2 stays positive, for gap >= 0.
double safe_step_s(double gap_m, double slope_mps, double bend_mps2) {
  const double root = std::sqrt(slope_mps * slope_mps + 2.0 * bend_mps2 * gap_m);
  return slope_mps > 0.0 ? (slope_mps + root) / bend_mps2 : 2.0 * gap_m / (root - slope_mps);
}

/// A bound of the envelope is passed by when the ball is higher by this: far below what matters (femtoseconds),
/// far above the rounding of heights.
constexpr double kClear_m = 1e-12;
/// Cells after which a search is given up: only an invalid state gets there.
constexpr int kMaxSteps = 10'000'000;

/// Lists up to this length are narrowed.
constexpr std::size_t kMostNarrowed = 32;

/// Asks the processor to load early what lies anywhere in memory; the search has other work meanwhile.
void prefetch(const void* place) {
#if defined(__GNUC__)
  __builtin_prefetch(place);
#else
  (void)place;
#endif
}

/// Where the surface's index of a site of the leaf is.
const std::uint32_t* asperity_of(const Envelope::Leaf& leaf, const Envelope::Site* site) {
  return leaf.asperities.data() + (site - leaf.sites.data());
}

/// Index into the surface of a site of the cell; -1 for nullptr, the smooth sphere.
std::int64_t index_of(const Envelope::Leaf& leaf, const Envelope::Site* site) {
  return site == nullptr ? -1 : std::int64_t{*asperity_of(leaf, site)};
}

/// The search for one flight; Path is the centre's: Parabola or DraggedPath.
template <class Path>
class Search {
 public:
  Search(const Ball& ball, const Envelope& envelope, const Path& path, const Pole& pole,
         std::optional<std::int64_t> left)
      : radius_m_(ball.radius_m),
        envelope_(envelope),
        path_(path),
        pole_(pole),
        bend_mps2_(path.bend_mps2() + radius_m_ * pole_.rate_radps * pole_.speed_radps),
        left_(left) {}

  struct Found {
    double t_s;
    const Envelope::Site* site;  ///< nullptr: the smooth sphere
    std::int64_t asperity;       ///< -1: the smooth sphere
  };

  Found run() {
    double t = time_of_unhindered_rise();
    for (int step = 0; step < kMaxSteps; ++step) {
      t = skip_above(envelope_.max_elevation(), t);
      const Pole here = pole_.from(t);
      const Vector3 n = here.along + here.cosine;
      // most often the leaf under the pole is where the ball comes down
      const Envelope::Leaf leaf = envelope_.leaf_at(n);
      for (const std::uint16_t k : leaf.list) prefetch(&leaf.sites[k]);
      for (const std::uint16_t k : leaf.list) prefetch(&leaf.asperities[k]);
      const double t_exit = t + leaf.margin_rad / pole_.speed_radps;
      const double t_reach = skip_above(leaf.max_elevation, t);
      if (t_reach < t_exit) {
        if (const auto found = search_leaf(leaf, here, t, t_reach, t_exit)) return *found;
        t = t_exit;
        continue;
      }
      // else stay in the widest cell that the ball is above; the leaf itself at the least
      const Envelope::Cell cell = envelope_.cell_below((path_.height_m(t) - kClear_m) / radius_m_, n);
      t = std::max(t_exit, std::min(t + cell.margin_rad / pole_.speed_radps, skip_above(cell.max_elevation, t)));
    }
    throw Error("flight: no contact found in " + std::to_string(kMaxSteps) +
                " cells of the surface; is the spin or the speed absurd?");
  }

 private:
  struct Candidate {
    double step_s = std::numeric_limits<double>::infinity();
    double gap_m = 0.0, slope_mps = 0.0;
    const Envelope::Site* site = nullptr;
  };

  /// The envelope follows the pole no faster than R |n'| sqrt(2 max E): a ball that rises faster leaves all behind.
  double time_of_unhindered_rise() const {
    const double chase_mps = radius_m_ * pole_.speed_radps * std::sqrt(2.0 * envelope_.max_elevation());
    if (!left_) return 0.0;
    return std::max(0.0, (path_.initial_velocity_mps() - chase_mps) / path_.bend_mps2());
  }

  double skip_above(double elevation, double t) const {
    const double level_m = radius_m_ * elevation;
    return path_.height_m(t) > level_m + kClear_m ? path_.descent_to(level_m, t) : t;
  }

  /// The sites of a leaf that are examined: all of its list, until most of it is ruled out. Longer lists than fit are
  /// not narrowed; leaves hold so many only where as many asperities meet in a point.
  struct LeafSites {
    std::span<const std::uint16_t> list;
    bool is_narrow = false;
    std::array<std::uint16_t, kMostNarrowed> few;
    std::array<double, kMostNarrowed> gap_m, slope_mps;
  };

  /// Advances from t to t_exit through a leaf; what it hits, if anything. @param here  the pole with its clock at
  /// t_here
  std::optional<Found> search_leaf(const Envelope::Leaf& leaf, const Pole& here, double t_here, double t,
                                   double t_exit) const {
    LeafSites listed;
    listed.list = leaf.list;
    while (t < t_exit) {
      const Candidate first = nearest(leaf, listed, t, here.at(t - t_here));
      const double resolution_s = 1e-15 + 4.0 * std::numeric_limits<double>::epsilon() * t;
      // after a safe step the gap is at most bend step^2: what is left is that over the closing speed
      const double left_s = bend_mps2_ * first.step_s * first.step_s / -first.slope_mps;
      if (first.slope_mps < 0.0 && left_s <= resolution_s)
        return Found{t + first.step_s, first.site, index_of(leaf, first.site)};
      if (!listed.is_narrow) narrow(listed, first, t_exit - t);
      t += std::max(first.step_s, resolution_s);
      if (path_.height_m(t) > radius_m_ * leaf.max_elevation + kClear_m)
        t = std::max(t, std::min(t_exit, skip_above(leaf.max_elevation, t)));
    }
    return std::nullopt;
  }

  /// The smallest safe step of all that can touch.
  Candidate nearest(const Envelope::Leaf& leaf, LeafSites& listed, double t, const Pole::Instant& pole) const {
    const double y = path_.height_m(t), v = path_.velocity_mps(t);
    Candidate first = judge(leaf, nullptr, y, v, t);
    for (std::size_t i = 0; i < listed.list.size(); ++i) {
      const Envelope::Site& site = leaf.sites[listed.list[i]];
      const double gap = y - radius_m_ * (site.height - 0.5 * norm2(pole.direction - site.direction));
      const double slope = v - radius_m_ * dot(site.direction, pole.velocity);
      if (i < kMostNarrowed) {
        listed.gap_m[i] = gap;
        listed.slope_mps[i] = slope;
      }
      if (is_open_until(first.step_s, gap, slope)) continue;
      const Candidate candidate = judge(leaf, &site, gap, slope, t);
      if (candidate.step_s < first.step_s) first = candidate;
    }
    return first;
  }

  /// Rules out what is open for sure until `first` has closed for sure, where that is before the leaf is left.
  void narrow(LeafSites& listed, const Candidate& first, double leaf_left_s) const {
    const double left = first.slope_mps * first.slope_mps - 2.0 * bend_mps2_ * first.gap_m;
    if (!(first.slope_mps < 0.0 && left > 0.0 && listed.list.size() <= kMostNarrowed)) return;
    const double latest_s = 2.0 * first.gap_m / (std::sqrt(left) - first.slope_mps);
    if (!(latest_s < leaf_left_s)) return;
    std::size_t n = 0;
    for (std::size_t i = 0; i < listed.list.size(); ++i) {
      listed.few[n] = listed.list[i];
      n += is_open_until(latest_s, listed.gap_m[i], listed.slope_mps[i]) ? 0 : 1;
    }
    listed.list = std::span(listed.few).first(n);
    listed.is_narrow = true;
  }

  bool is_open_until(double step_s, double gap_m, double slope_mps) const {
    return gap_m > 0.0 && gap_m + step_s * (slope_mps - 0.5 * bend_mps2_ * step_s) >= 0.0;
  }

  Candidate judge(const Envelope::Leaf& leaf, const Envelope::Site* site, double gap_m, double slope_mps,
                  double t) const {
    const double bend = site == nullptr ? path_.bend_mps2() : bend_mps2_;
    // what was just left opens with the contact's speed: its gap cannot close before 2 slope / bend
    if (t == 0.0 && slope_mps > 0.0 && left_ == index_of(leaf, site)) return {slope_mps / bend, gap_m, slope_mps, site};
    if (gap_m > 0.0) return {safe_step_s(gap_m, slope_mps, bend), gap_m, slope_mps, site};
    if (slope_mps < 0.0) return {0.0, gap_m, slope_mps, site};
    return {2.0 * slope_mps / bend, gap_m, slope_mps, site};
  }

  double radius_m_;
  const Envelope& envelope_;
  const Path& path_;
  const Pole& pole_;
  double bend_mps2_;  ///< bound of -gap'' for asperities
  std::optional<std::int64_t> left_;
};

void move_centre(const Parabola&, double t, Vector3 g, BallState& state) {
  const Vector3 v = state.motion.velocity_mps;
  state.x_m += t * (v.x + 0.5 * g.x * t);
  state.y_m += t * (v.y + 0.5 * g.y * t);
  state.clearance_m += t * (v.z + 0.5 * g.z * t);
  state.motion.velocity_mps = v + t * g;
}

void move_centre(const DraggedPath& path, double t, Vector3, BallState& state) {
  const DraggedPath::Node node = path.at(t);
  state.x_m = node.place_m.x;
  state.y_m = node.place_m.y;
  state.clearance_m = node.place_m.z;
  state.motion.velocity_mps = node.velocity_mps;
}

template <class Path>
FirstContact contact_on(const Path& path, const Ball& ball, const Envelope& envelope, const BallState& start, Vector3 g,
                        std::optional<std::int64_t> left) {
  const Vector3 spin = start.motion.spin_radps;
  const Pole pole = make_pole(start.orientation, spin);
  const auto [dt_s, site, asperity] = Search<Path>(ball, envelope, path, pole, left).run();
  FirstContact contact{dt_s, asperity, {0.0, 0.0, -ball.radius_m}, start};
  move_centre(path, dt_s, g, contact.state);
  contact.state.orientation = normalized(rotation_by(dt_s * spin) * start.orientation);
  if (site != nullptr)
    contact.lever_m =
        ball.radius_m * (rotate(contact.state.orientation, site->direction) - Vector3{0.0, 0.0, site->height});
  return contact;
}

}  // namespace

FirstContact find_first_contact(const Ball& ball, const Envelope& envelope, const BallState& start,
                                Vector3 gravity_mps2, std::optional<std::int64_t> left, const std::optional<Air>& air) {
  if (!(gravity_mps2.z < 0.0))
    throw InvalidArgument("flight: gravity must pull towards the plate, its normal part is " +
                          std::to_string(gravity_mps2.z) + " m/s^2; tilt the plate less");
  if (air) return contact_on(DraggedPath(ball, *air, start, gravity_mps2), ball, envelope, start, gravity_mps2, left);
  const Parabola path{start.clearance_m, start.motion.velocity_mps.z, -gravity_mps2.z};
  return contact_on(path, ball, envelope, start, gravity_mps2, left);
}

}  // namespace bouncelab::sim
