// SPDX-License-Identifier: GPL-3.0-or-later
#include "excitation/resonator_bank.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::synthesis {
namespace {

using Complex = std::complex<double>;

/// Re sum_p a_p z_p, in four partial sums: the compiler may not reorder a sum, we may.
double real_part_of_product(const PoleValues& a, const PoleValues& z) {
  double sums[4] = {0.0, 0.0, 0.0, 0.0};
  const std::size_t n = a.size(), n_whole = n / 4 * 4;
  for (std::size_t k = 0; k < n_whole; k += 4)
    for (std::size_t lane = 0; lane < 4; ++lane)
      sums[lane] += a.re[k + lane] * z.re[k + lane] - a.im[k + lane] * z.im[k + lane];
  for (std::size_t k = n_whole; k < n; ++k) sums[0] += a.re[k] * z.re[k] - a.im[k] * z.im[k];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/// z times e, pole by pole.
void rotate(PoleValues& z, const PoleValues& e) {
  const std::size_t n = z.size();
  double* re = z.re.data();
  double* im = z.im.data();
  for (std::size_t p = 0; p < n; ++p) {
    const double re_before = re[p];
    re[p] = e.re[p] * re_before - e.im[p] * im[p];
    im[p] = e.re[p] * im[p] + e.im[p] * re_before;
  }
}

void add_scaled(PoleValues& z, const PoleValues& k, double factor) {
  audio::add_scaled(z.re.data(), factor, k.re.data(), z.size());
  audio::add_scaled(z.im.data(), factor, k.im.data(), z.size());
}

/// How many resonators ring together: a sample is loaded and stored once for all of them.
constexpr std::size_t kTogether = 4;

/// Free ringing of four resonators: blocks of out_j += sum_k Re((re_k + i im_k)(c_kj + i s_kj)), each followed by the
/// values' rotation over a block. The values are rotated in double precision, whatever T they ring in.
/// @param c, s  four rows of kBlock
template <class T>
[[gnu::always_inline]] inline void add_four(std::span<T> out, const T* c, const T* s, const double* step_re,
                                            const double* step_im, double silence, double* re, double* im) {
  constexpr auto kFrames = static_cast<std::size_t>(ResonatorBank::kBlock);
  const T *c1 = c + kFrames, *c2 = c1 + kFrames, *c3 = c2 + kFrames;
  const T *s1 = s + kFrames, *s2 = s1 + kFrames, *s3 = s2 + kFrames;
  for (T* y = out.data(); y != out.data() + out.size(); y += kFrames) {
    double loudest = 0.0;
    for (std::size_t k = 0; k < kTogether; ++k) loudest = std::max(loudest, std::abs(re[k]) + std::abs(im[k]));
    if (loudest < silence) {
      std::fill_n(re, kTogether, 0.0);
      std::fill_n(im, kTogether, 0.0);
      return;
    }
    const T re0 = static_cast<T>(re[0]), re1 = static_cast<T>(re[1]), re2 = static_cast<T>(re[2]),
            re3 = static_cast<T>(re[3]);
    const T im0 = static_cast<T>(im[0]), im1 = static_cast<T>(im[1]), im2 = static_cast<T>(im[2]),
            im3 = static_cast<T>(im[3]);
    for (std::size_t j = 0; j < kFrames; ++j)
      y[j] += ((re0 * c[j] - im0 * s[j]) + (re1 * c1[j] - im1 * s1[j])) +
              ((re2 * c2[j] - im2 * s2[j]) + (re3 * c3[j] - im3 * s3[j]));
    for (std::size_t k = 0; k < kTogether; ++k) {
      const double re_before = re[k];
      re[k] = re_before * step_re[k] - im[k] * step_im[k];
      im[k] = re_before * step_im[k] + im[k] * step_re[k];
    }
  }
}

BOUNCELAB_VECTOR_CLONES void add_ringing(std::span<float> out, const float* c, const float* s, const double* step_re,
                                         const double* step_im, double silence, double* re, double* im) {
  add_four(out, c, s, step_re, step_im, silence, re, im);
}

void add_ringing(std::span<double> out, const double* c, const double* s, const double* step_re, const double* step_im,
                 double silence, double* re, double* im) {
  add_four(out, c, s, step_re, step_im, silence, re, im);
}

std::size_t rounded_up(std::size_t n) { return (n + kTogether - 1) / kTogether * kTogether; }

PoleValues product(const PoleValues& a, const PoleValues& b) {
  PoleValues result(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) result.set(k, a[k] * b[k]);
  return result;
}

/// Gauss points within one sample interval: two waves, each up to its own frequency, beat over it. With half the phase
/// theta of their product, 0.7 theta + 5.5 points leave 1e-9 (error term of the rule applied to exp(i theta x)).
int n_interval_nodes(double max_radps, double rate_hz) {
  const double theta = 0.5 * (std::numbers::pi + max_radps / rate_hz);
  return static_cast<int>(std::ceil(0.7 * theta + 5.5));
}

double largest_frequency_radps(const std::vector<Complex>& poles) {
  double largest = 0.0;
  for (const Complex& pole : poles) largest = std::max(largest, hypot(pole.real(), pole.imag()));
  return largest;
}

double smallest_decay_per_s(const std::vector<Complex>& poles) {
  double smallest = -poles.front().real();
  for (const Complex& pole : poles) smallest = std::min(smallest, -pole.real());
  return smallest;
}

}  // namespace

ResonatorBank::ResonatorBank(std::vector<Complex> poles, double rate_hz)
    : poles_(std::move(poles)),
      rate_hz_(rate_hz),
      memory_frames_(static_cast<std::int64_t>(log(1e11) / smallest_decay_per_s(poles_) * rate_hz)),
      interval_(gauss_legendre(n_interval_nodes(largest_frequency_radps(poles_), rate_hz), 0.0, 1.0)),
      pole_steps_(size()),
      step_(size()),
      block_step_(rounded_up(size())),
      kick_(interval_.nodes.size(), PoleValues(size())),
      waves_(rounded_up(size()) * static_cast<std::size_t>(kBlock)),
      single_waves_(waves_.re.size()) {
  for (std::size_t p = 0; p < size(); ++p) {
    const Complex s = poles_[p] / rate_hz;
    pole_steps_.set(p, s);
    step_.set(p, exp(s));
    block_step_.set(p, exp(s * static_cast<double>(kBlock)));
    for (std::size_t i = 0; i < kick_.size(); ++i)
      kick_[i].set(p, interval_.weights[i] * exp(s * (1.0 - interval_.nodes[i])));
    for (std::int64_t j = 0; j < kBlock; ++j)
      waves_.set(p * static_cast<std::size_t>(kBlock) + static_cast<std::size_t>(j), exp(s * static_cast<double>(j)));
  }
  const auto in_single = [](double x) { return static_cast<float>(x); };
  std::transform(waves_.re.begin(), waves_.re.end(), single_waves_.re.begin(), in_single);
  std::transform(waves_.im.begin(), waves_.im.end(), single_waves_.im.begin(), in_single);
}

std::vector<double> ResonatorBank::force(const Contact& contact, std::int64_t first, std::size_t n_frames,
                                         double fraction) const {
  std::vector<double> g(n_frames, 0.0);
  const PointImpulses pulse = hertz_impulses(contact.duration_samples);
  const double offset = static_cast<double>(first) + fraction - contact.arrival_samples;
  for (std::size_t q = 0; q < pulse.nodes.size(); ++q)
    filter_.add(offset - contact.duration_samples * pulse.nodes[q], contact.impulse * pulse.weights[q], g);
  return g;
}

ContactWave ResonatorBank::wave(const Contact& contact, const PoleValues& amplitudes, bool with_slopes) const {
  constexpr double kReach = ConverterFilter::kHalfWidth_samples;
  const auto first = static_cast<std::int64_t>(std::floor(contact.arrival_samples - kReach));
  const auto last = static_cast<std::int64_t>(std::ceil(contact.arrival_samples + contact.duration_samples + kReach));
  const std::int64_t end = (last + kBlock - 1) / kBlock * kBlock;
  const auto n_driven = static_cast<std::size_t>(last - first), n = static_cast<std::size_t>(end - first);
  std::vector<std::vector<double>> drive;
  for (const double node : interval_.nodes) drive.push_back(force(contact, first, n_driven, node));

  ContactWave wave{first, std::vector<double>(n), {}, PoleValues(size()), {}};
  // dy/dt = Re sum a_p (s_p z_p + g)
  const PoleValues slope_amplitudes = with_slopes ? product(amplitudes, pole_steps_) : PoleValues();
  if (with_slopes) {
    wave.slopes = force(contact, first, n, 0.0);
    const double direct = std::accumulate(amplitudes.re.begin(), amplitudes.re.end(), 0.0);
    for (double& slope : wave.slopes) slope *= direct;
  }
  PoleValues z(size());
  for (std::size_t k = 0; k < n; ++k) {
    wave.samples[k] = real_part_of_product(amplitudes, z);
    if (with_slopes) wave.slopes[k] += real_part_of_product(slope_amplitudes, z);
    rotate(z, step_);
    if (k < n_driven)
      for (std::size_t i = 0; i < drive.size(); ++i) add_scaled(z, kick_[i], drive[i][k]);
  }
  wave.ringing = product(amplitudes, z);
  return wave;
}

template <class T>
void ResonatorBank::ring_together(PoleValues& state, double silence, const PoleValuesOf<T>& waves,
                                  std::span<T> out) const {
  constexpr std::size_t kRun = 16 * static_cast<std::size_t>(kBlock);  // they fit the first-level cache
  for (; !out.empty(); out = out.subspan(std::min(kRun, out.size())))
    for (std::size_t p = 0; p < size(); p += kTogether) {
      const std::size_t at = p * static_cast<std::size_t>(kBlock), n = std::min(kTogether, size() - p);
      double re[kTogether]{}, im[kTogether]{};
      std::copy_n(state.re.data() + p, n, re);
      std::copy_n(state.im.data() + p, n, im);
      add_ringing(out.first(std::min(kRun, out.size())), waves.re.data() + at, waves.im.data() + at,
                  block_step_.re.data() + p, block_step_.im.data() + p, silence, re, im);
      std::copy_n(re, n, state.re.data() + p);
      std::copy_n(im, n, state.im.data() + p);
    }
}

void ResonatorBank::ring(PoleValues& state, double silence, std::span<double> out) const {
  ring_together(state, silence, waves_, out);
}
void ResonatorBank::ring(PoleValues& state, double silence, std::span<float> out) const {
  ring_together(state, silence, single_waves_, out);
}

void ResonatorBank::advance(PoleValues& state, std::int64_t n_frames) const {
  const double seconds = static_cast<double>(n_frames) / rate_hz_;
  for (std::size_t p = 0; p < size(); ++p) state.set(p, state[p] * exp(poles_[p] * seconds));
}

void ResonatorBank::advance_in_block(PoleValues& state, std::int64_t n_frames) const {
  for (std::size_t p = 0; p < size(); ++p)
    state.set(p, state[p] * waves_[p * static_cast<std::size_t>(kBlock) + static_cast<std::size_t>(n_frames)]);
}

}  // namespace bouncelab::synthesis
