// SPDX-License-Identifier: GPL-3.0-or-later
#include "wave_template.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "bouncelab/core/units.hpp"
#include "products.hpp"

namespace bouncelab {
namespace {

constexpr double kKaiserBeta = 6.0;

/// Modified Bessel function I_0 by its power series, to 1e-12 for |x| <= 6.
double bessel_i0(double x) {
  double sum = 1.0;
  double term = 1.0;
  for (int k = 1; k < 30; ++k) {
    term *= 0.25 * x * x / (k * k);
    sum += term;
  }
  return sum;
}

/// Windowed sinc at a distance of x samples, |x| <= reach.
double kernel(double x, double reach) {
  static const double kPeak = bessel_i0(kKaiserBeta);
  const double ratio = x / reach;
  if (std::abs(ratio) >= 1.0) return 0.0;
  const double window = bessel_i0(kKaiserBeta * std::sqrt(1.0 - ratio * ratio)) / kPeak;
  return window * (x == 0.0 ? 1.0 : std::sin(kPi * x) / (kPi * x));
}

}  // namespace

FractionalShift::FractionalShift(double fraction) {
  // out[n] = sum_k tap[k] x[n + k], tap[k] = kernel(kReach + fraction - k)
  for (std::size_t k = 0; k < 2 * kReach; ++k)
    tap_[k] = static_cast<float>(kernel(static_cast<double>(kReach) + fraction - static_cast<double>(k), kReach));
}

void FractionalShift::apply(std::span<const float> x, std::span<float> out) const {
  assert(x.size() >= out.size() + 2 * kReach);
  correlate(x, tap_, out);
}

WaveTemplate::WaveTemplate(std::vector<float> mean) : n_(mean.size()), mean_(std::move(mean)), phases_(kPhases) {
  constexpr std::size_t kReach = FractionalShift::kReach;
  std::vector<float> padded(n_ + 2 * kReach + 1, 0.0F);
  std::copy(mean_.begin(), mean_.end(), padded.begin() + kReach);
  std::vector<float> before(n_);
  std::vector<float> after(n_);
  constexpr double kStep =
      1.0 / 64.0;  // for the derivative: error (2 pi f step)^2 / 6 < 4e-4 below the Nyquist frequency
  for (std::size_t p = 0; p < kPhases; ++p) {
    Phase& phase = phases_[p];
    const double shift = static_cast<double>(p) / kPhases;
    phase.wave.resize(n_);
    phase.derivative.resize(n_);
    // mean(n - shift) = x(n + kReach - shift)
    const auto at = [&](double s, std::vector<float>& out) {
      const double whole = std::ceil(s - 0.5);
      const std::vector<float>* source = &padded;
      std::vector<float> moved;
      if (whole > 0.0) {
        moved.assign(padded.size(), 0.0F);
        std::copy(padded.begin(), padded.end() - 1, moved.begin() + 1);
        source = &moved;
      }
      FractionalShift(whole - s).apply(*source, out);
    };
    at(shift, phase.wave);
    at(shift - kStep, after);
    at(shift + kStep, before);
    for (std::size_t n = 0; n < n_; ++n) phase.derivative[n] = (after[n] - before[n]) / static_cast<float>(2.0 * kStep);
    phase.ww.assign(n_ + 1, 0.0);
    phase.wd.assign(n_ + 1, 0.0);
    phase.dd.assign(n_ + 1, 0.0);
    for (std::size_t n = 0; n < n_; ++n) {
      const double w = phase.wave[n];
      const double d = phase.derivative[n];
      phase.ww[n + 1] = phase.ww[n] + w * w;
      phase.wd[n + 1] = phase.wd[n] + w * d;
      phase.dd[n + 1] = phase.dd[n] + d * d;
    }
  }
}

double WaveTemplate::energy(std::size_t n) const { return phases_[0].ww[std::min(n, n_)]; }

WavePlace WaveTemplate::search(std::span<const float> sound, std::ptrdiff_t first, std::ptrdiff_t last,
                               std::size_t n) const {
  n = std::min(n, n_);
  // in halves: at a whole sample's spacing what lies near the Nyquist frequency could be missed altogether
  std::vector<double> products;
  for (std::ptrdiff_t shift = first; shift <= last; ++shift)
    for (const std::size_t p : {std::size_t{0}, kPhases / 2})
      products.push_back(dot(sound.subspan(static_cast<std::size_t>(shift), n), std::span(phases_[p].wave).first(n)));
  const auto best = std::max_element(products.begin(), products.end());
  const auto shift_of = [&](auto place) {
    return static_cast<double>(first) + 0.5 * static_cast<double>(place - products.begin());
  };
  WavePlace found{shift_of(best), shift_of(best), INFINITY};
  double second = 0.0;
  for (auto k = products.begin(); k != products.end(); ++k) {
    const bool is_peak = (k == products.begin() || *k >= *(k - 1)) && (k + 1 == products.end() || *k >= *(k + 1));
    if (!is_peak || std::abs(k - best) <= 2 || *k <= second) continue;
    second = *k;
    found.runner_up = shift_of(k);
  }
  const double top = std::max(0.0, *best);
  found.lead = 0.5 * (top * top - second * second) / phases_[0].ww[n];
  return found;
}

WaveFit WaveTemplate::fit(std::span<const float> sound, double start, std::size_t n) const {
  n = std::min(n, n_);
  WaveFit result;
  double shift = start;
  constexpr int kMostSteps = 8;
  for (int step = 0; step < kMostSteps; ++step) {
    const double sixteenths = std::round(shift * kPhases);
    const auto whole = static_cast<std::ptrdiff_t>(std::floor(sixteenths / kPhases));
    const auto p = static_cast<std::size_t>(sixteenths - static_cast<double>(whole) * kPhases);
    if (whole < 0 || whole + static_cast<std::ptrdiff_t>(n) > static_cast<std::ptrdiff_t>(sound.size())) break;
    const Phase& phase = phases_[p];
    const auto stretch = sound.subspan(static_cast<std::size_t>(whole), n);
    const double xw = dot(stretch, std::span(phase.wave).first(n));
    const double xd = dot(stretch, std::span(phase.derivative).first(n));
    const double ww = phase.ww[n];
    const double wd = phase.wd[n];
    const double dd = phase.dd[n];
    const double determinant = ww * dd - wd * wd;
    if (!(determinant > 0.0)) break;
    const double amplitude = (dd * xw - wd * xd) / determinant;
    const double slope = (ww * xd - wd * xw) / determinant;  // amplitude times minus the remaining shift
    const double here = sixteenths / kPhases;
    result.amplitude = amplitude;
    result.gain = xw > 0.0 ? 0.5 * xw * xw / ww : 0.0;
    if (amplitude <= 0.0) break;
    const double move = std::clamp(-slope / amplitude, -0.5, 0.5);
    shift = here + move;
    result.sigma_shift = std::sqrt(ww / determinant) / amplitude;
    const double xx = dot(stretch, stretch);
    result.misfit = std::max(0.0, xx - amplitude * xw - slope * xd) / static_cast<double>(n);
    if (std::abs(move) <= 0.51 / kPhases) break;  // the linear step is exact to 0.2 % of itself within its own phase
  }
  result.shift = shift;
  return result;
}

void WaveTemplate::subtract(std::span<float> sound, double shift, double amplitude) const {
  const double sixteenths = std::round(shift * kPhases);
  const auto whole = static_cast<std::ptrdiff_t>(std::floor(sixteenths / kPhases));
  const Phase& phase = phases_[static_cast<std::size_t>(sixteenths - static_cast<double>(whole) * kPhases)];
  const auto a = static_cast<float>(amplitude);
  const auto b = static_cast<float>(-amplitude * (shift - sixteenths / kPhases));
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, whole);
  const std::ptrdiff_t last =
      std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(sound.size()), whole + static_cast<std::ptrdiff_t>(n_));
  for (std::ptrdiff_t n = first; n < last; ++n) {
    const auto k = static_cast<std::size_t>(n - whole);
    sound[static_cast<std::size_t>(n)] -= a * phase.wave[k] + b * phase.derivative[k];
  }
}

}  // namespace bouncelab
