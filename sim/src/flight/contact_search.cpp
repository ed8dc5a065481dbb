// SPDX-License-Identifier: GPL-3.0-or-later
#include "flight/contact_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "bouncelab/core/error.hpp"

namespace bouncelab::sim {
namespace {

using PathNode = DraggedPath::Node;

/// Shortest step: at the summit itself.
constexpr double kShortestStep_s = 1e-7;

template <class Acceleration>
PathNode stepped(const PathNode& from, double h, const Acceleration& acceleration) {
  const Vector3 v1 = from.velocity_mps, a1 = from.acceleration_mps2;
  const Vector3 v2 = v1 + (0.5 * h) * a1, a2 = acceleration(v2);
  const Vector3 v3 = v1 + (0.5 * h) * a2, a3 = acceleration(v3);
  const Vector3 v4 = v1 + h * a3, a4 = acceleration(v4);
  const Vector3 v = v1 + (h / 6.0) * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  const Vector3 x = from.place_m + (h / 6.0) * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
  return {from.t_s + h, x, v, acceleration(v)};
}

/// Quintic Hermite interpolation between two nodes, and its derivative.
PathNode between(const PathNode& p, const PathNode& q, double t) {
  const double h = q.t_s - p.t_s, s = (t - p.t_s) / h;
  // in powers of s: x = x0 + h v0 s + h^2 a0 s^2/2 + c3 s^3 + c4 s^4 + c5 s^5
  const Vector3 rest = q.place_m - p.place_m - h * p.velocity_mps - (0.5 * h * h) * p.acceleration_mps2;
  const Vector3 slope = h * (q.velocity_mps - p.velocity_mps) - (h * h) * p.acceleration_mps2;
  const Vector3 bend = (h * h) * (q.acceleration_mps2 - p.acceleration_mps2);
  const Vector3 c3 = 10.0 * rest - 4.0 * slope + 0.5 * bend;
  const Vector3 c4 = -15.0 * rest + 7.0 * slope - bend;
  const Vector3 c5 = 6.0 * rest - 3.0 * slope + 0.5 * bend;
  const double s2 = s * s;
  const Vector3 x = p.place_m + (h * s) * p.velocity_mps + (0.5 * h * h * s2) * p.acceleration_mps2 +
                    (s * s2) * (c3 + s * c4 + s2 * c5);
  const Vector3 v =
      p.velocity_mps + (h * s) * p.acceleration_mps2 + (s2 / h) * (3.0 * c3 + (4.0 * s) * c4 + (5.0 * s2) * c5);
  return {t, x, v, p.acceleration_mps2};
}

}  // namespace

Vector3 drag_acceleration_mps2(const Ball& ball, const Air& air, Vector3 velocity_mps) {
  return -drag_rate_per_s(ball, air, norm(velocity_mps)) * velocity_mps;
}

DraggedPath::DraggedPath(const Ball& ball, const Air& air, const BallState& start, Vector3 gravity_mps2) {
  const auto acceleration = [&](Vector3 v) { return gravity_mps2 + drag_acceleration_mps2(ball, air, v); };
  const Vector3 v = start.motion.velocity_mps;
  const double g = -gravity_mps2.z;
  nodes_.push_back({0.0, {start.x_m, start.y_m, start.clearance_m}, v, acceleration(v)});
  const double fall_s = std::sqrt(v.z * v.z + 2.0 * g * std::max(0.0, start.clearance_m)) / g;
  while (nodes_.back().place_m.z > 0.0 || nodes_.back().velocity_mps.z > 0.0 || nodes_.size() < 2) {
    const double to_summit_s = std::abs(nodes_.back().velocity_mps.z) / g;
    const double h = std::clamp(0.25 * to_summit_s, kShortestStep_s, std::max(kShortestStep_s, fall_s / 128.0));
    nodes_.push_back(stepped(nodes_.back(), h, acceleration));
  }
  // drag adds to gravity only on the way up, where the start is fastest
  bend_mps2_ = g + norm(nodes_.front().acceleration_mps2 - gravity_mps2);
}

DraggedPath::Node DraggedPath::at(double t_s) const {
  auto after = std::upper_bound(nodes_.begin() + 1, nodes_.end() - 1, t_s,
                                [](double t, const Node& node) { return t < node.t_s; });
  return between(*(after - 1), *after, t_s);
}

void DraggedPath::move(double t_s, BallState& state) const {
  const Node node = at(t_s);
  state.x_m = node.place_m.x;
  state.y_m = node.place_m.y;
  state.clearance_m = node.place_m.z;
  state.motion.velocity_mps = node.velocity_mps;
}

double DraggedPath::descent_to(double level_m, double t_s) const {
  if (height_m(t_s) <= level_m) return t_s;
  // nodes from the end of the path up to the first that is at or above the level
  std::size_t k = nodes_.size() - 1;
  while (k > 0 && nodes_[k].place_m.z < level_m) --k;
  double t = nodes_[k].t_s;
  for (int i = 0; i < 50; ++i) {  // Newton from above on a concave arc: overshoots once at the most, then from below
    const Node here = at(t);
    if (!(here.velocity_mps.z < 0.0)) {
      t += kShortestStep_s;
      continue;
    }
    const double step = (level_m - here.place_m.z) / here.velocity_mps.z;
    t += step;
    if (std::abs(step) < 1e-16 + 2e-16 * t) break;
  }
  return std::max(t, t_s);
}

namespace {

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

}  // namespace

template <class Path>
ContactSearch<Path>::ContactSearch(const Ball& ball, const Envelope& envelope, const BallState& start, Path path,
                                   std::optional<std::int64_t> left)
    : radius_m_(ball.radius_m),
      envelope_(&envelope),
      start_(start),
      path_(std::move(path)),
      pole_(make_pole(start.orientation, start.motion.spin_radps)),
      bend_mps2_(path_.bend_mps2() + radius_m_ * pole_.rate_radps * pole_.speed_radps),
      left_(left) {
  t_ = time_of_unhindered_rise();
  go_down_to_envelope();
}

template <class Path>
bool ContactSearch<Path>::find_leaf() {
  const std::optional<Envelope::Leaf> found = leaf_search_->advance();
  if (found) leaf_ = *found;
  return found.has_value();
}

template <class Path>
FirstContact ContactSearch<Path>::find_contact() {
  for (int step = 0; step < kMaxSteps; ++step) {
    // most often the leaf under the pole is where the ball comes down
    const double t_exit = t_ + leaf_.margin_rad / pole_.speed_radps;
    if (const auto found = find_in_leaf(t_exit)) return contact_of(*found);
    leave_leaf(t_exit);
    go_down_to_envelope();
    while (!find_leaf()) {
    }
  }
  throw Error("flight: no contact found in " + std::to_string(kMaxSteps) +
              " cells of the surface; is the spin or the speed absurd?");
}

/// The envelope follows the pole no faster than R |n'| sqrt(2 max E): a ball that rises faster leaves all behind.
template <class Path>
double ContactSearch<Path>::time_of_unhindered_rise() const {
  const double chase_mps = radius_m_ * pole_.speed_radps * std::sqrt(2.0 * envelope_->max_elevation());
  if (!left_) return 0.0;
  return std::max(0.0, (path_.initial_velocity_mps() - chase_mps) / path_.bend_mps2());
}

template <class Path>
double ContactSearch<Path>::skip_above(double elevation, double t) const {
  const double level_m = radius_m_ * elevation;
  return path_.height_m(t) > level_m + kClear_m ? path_.descent_to(level_m, t) : t;
}

template <class Path>
void ContactSearch<Path>::go_down_to_envelope() {
  t_ = skip_above(envelope_->max_elevation(), t_);
  here_ = pole_.from(t_);
  leaf_search_.emplace(*envelope_, here_.direction());
}

/// After a leaf without a contact.
template <class Path>
void ContactSearch<Path>::leave_leaf(double t_exit) {
  if (skip_above(leaf_.max_elevation, t_) < t_exit) {
    t_ = t_exit;
    return;
  }
  // stay in the widest cell that the ball is above; the leaf itself at the least
  const Envelope::Cell cell = envelope_->cell_below((path_.height_m(t_) - kClear_m) / radius_m_, here_.direction());
  t_ = std::max(t_exit, std::min(t_ + cell.margin_rad / pole_.speed_radps, skip_above(cell.max_elevation, t_)));
}

template <class Path>
FirstContact ContactSearch<Path>::contact_of(const Found& found) const {
  const double t = found.t_s;
  FirstContact contact{t, index_of(found.site), {0.0, 0.0, -radius_m_}, start_};
  path_.move(t, contact.state);
  contact.state.orientation = normalized(rotation_by(t * start_.motion.spin_radps) * start_.orientation);
  if (found.site != nullptr)
    contact.lever_m =
        radius_m_ * (rotate(contact.state.orientation, found.site->direction) - Vector3{0.0, 0.0, found.site->height});
  return contact;
}

/// Advances from t_ to t_exit through the leaf; what is hit, if anything.
template <class Path>
auto ContactSearch<Path>::find_in_leaf(double t_exit) const -> std::optional<Found> {
  LeafSites listed;
  listed.list = leaf_.list;
  double t = skip_above(leaf_.max_elevation, t_);
  while (t < t_exit) {
    const Candidate first = nearest(listed, t, here_.at(t - t_));
    const double resolution_s = 1e-15 + 4.0 * std::numeric_limits<double>::epsilon() * t;
    // after a safe step the gap is at most bend step^2: what is left is that over the closing speed
    const double left_s = bend_mps2_ * first.step_s * first.step_s / -first.slope_mps;
    if (first.slope_mps < 0.0 && left_s <= resolution_s) return Found{t + first.step_s, first.site};
    if (!listed.is_narrow) narrow(listed, first, t_exit - t);
    t += std::max(first.step_s, resolution_s);
    if (path_.height_m(t) > radius_m_ * leaf_.max_elevation + kClear_m)
      t = std::max(t, std::min(t_exit, skip_above(leaf_.max_elevation, t)));
  }
  return std::nullopt;
}

/// The smallest safe step of all that can touch.
template <class Path>
auto ContactSearch<Path>::nearest(LeafSites& listed, double t, const Pole::Instant& pole) const -> Candidate {
  const double y = path_.height_m(t), v = path_.velocity_mps(t);
  Candidate first = judge(nullptr, y, v, t);
  for (std::size_t i = 0; i < listed.list.size(); ++i) {
    const Envelope::Site& site = leaf_.sites[listed.list[i]];
    const double gap = y - radius_m_ * (site.height - 0.5 * norm2(pole.direction - site.direction));
    const double slope = v - radius_m_ * dot(site.direction, pole.velocity);
    if (i < LeafSites::kMostNarrowed) {
      listed.gap_m[i] = gap;
      listed.slope_mps[i] = slope;
    }
    if (is_open_until(first.step_s, gap, slope)) continue;
    const Candidate candidate = judge(&site, gap, slope, t);
    if (candidate.step_s < first.step_s) first = candidate;
  }
  return first;
}

/// Rules out what is open for sure until `first` has closed for sure, where that is before the leaf is left.
template <class Path>
void ContactSearch<Path>::narrow(LeafSites& listed, const Candidate& first, double leaf_left_s) const {
  const double left = first.slope_mps * first.slope_mps - 2.0 * bend_mps2_ * first.gap_m;
  if (!(first.slope_mps < 0.0 && left > 0.0 && listed.list.size() <= LeafSites::kMostNarrowed)) return;
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

template <class Path>
bool ContactSearch<Path>::is_open_until(double step_s, double gap_m, double slope_mps) const {
  return gap_m > 0.0 && gap_m + step_s * (slope_mps - 0.5 * bend_mps2_ * step_s) >= 0.0;
}

template <class Path>
auto ContactSearch<Path>::judge(const Envelope::Site* site, double gap_m, double slope_mps, double t) const
    -> Candidate {
  const double bend = site == nullptr ? path_.bend_mps2() : bend_mps2_;
  // what was just left opens with the contact's speed: its gap cannot close before 2 slope / bend
  if (t == 0.0 && slope_mps > 0.0 && left_ == index_of(site)) return {slope_mps / bend, gap_m, slope_mps, site};
  if (gap_m > 0.0) return {safe_step_s(gap_m, slope_mps, bend), gap_m, slope_mps, site};
  if (slope_mps < 0.0) return {0.0, gap_m, slope_mps, site};
  return {2.0 * slope_mps / bend, gap_m, slope_mps, site};
}

/// Index into the surface; -1 for nullptr, the smooth sphere.
template <class Path>
std::int64_t ContactSearch<Path>::index_of(const Envelope::Site* site) const {
  return site == nullptr ? -1 : std::int64_t{leaf_.asperities[static_cast<std::size_t>(site - leaf_.sites.data())]};
}

template class ContactSearch<Parabola>;
template class ContactSearch<DraggedPath>;

namespace {

template <class Path>
FirstContact contact_on(Path path, const Ball& ball, const Envelope& envelope, const BallState& start,
                        std::optional<std::int64_t> left) {
  ContactSearch<Path> search(ball, envelope, start, std::move(path), left);
  while (!search.find_leaf()) {
  }
  return search.find_contact();
}

}  // namespace

FirstContact find_first_contact(const Ball& ball, const Envelope& envelope, const BallState& start,
                                Vector3 gravity_mps2, std::optional<std::int64_t> left, const std::optional<Air>& air) {
  if (!(gravity_mps2.z < 0.0))
    throw InvalidArgument("flight: gravity must pull towards the plate, its normal part is " +
                          std::to_string(gravity_mps2.z) + " m/s^2; tilt the plate less");
  if (air) return contact_on(DraggedPath(ball, *air, start, gravity_mps2), ball, envelope, start, left);
  return contact_on(Parabola(start, gravity_mps2), ball, envelope, start, left);
}

Vector3 mean_gradient(const Envelope& envelope, Vector3 n, double alpha_rad) {
  constexpr int kCirclePoints = 256;
  // any two axes across n; the smallest component of n is furthest from parallel
  const Vector3 helper = std::abs(n.x) < 0.6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  const Vector3 e1 = normalized(cross(n, helper)), e2 = cross(n, e1);
  const SinCos alpha = sin_cos(alpha_rad);
  Vector3 sum;
  for (int k = 0; k < kCirclePoints; ++k) {
    const SinCos phi = sin_cos(2.0 * kPi * k / kCirclePoints);
    const Vector3 outwards = phi.cos * e1 + phi.sin * e2;
    sum = sum + envelope.support(normalized(alpha.cos * n + alpha.sin * outwards)).elevation * outwards;
  }
  return (2.0 / (kCirclePoints * alpha.sin)) * sum;
}

Vector3 patch_lever_m(const Ball& ball, const Material& plate, const Envelope& envelope, const FirstContact& contact) {
  const double speed_mps = std::abs(contact.state.motion.velocity_mps.z);
  const double alpha_rad = hertz_patch_radius_m(ball, plate, speed_mps) / ball.radius_m;
  if (!(alpha_rad > 0.0)) return contact.lever_m;
  const Quaternion q = contact.state.orientation;
  const Vector3 n = normalized(rotate(conjugate(q), {0, 0, -1}));
  const Vector3 offset = rotate(q, mean_gradient(envelope, n, alpha_rad));
  return {ball.radius_m * offset.x, ball.radius_m * offset.y, contact.lever_m.z};
}

}  // namespace bouncelab::sim
