// SPDX-License-Identifier: GPL-3.0-or-later
#include "resonator_bank.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bouncelab/core/units.hpp"
#include "hertz_pulse.hpp"

namespace bouncelab {
namespace {

using Complex = std::complex<double>;

// Wider registers where the processor has them. Without fused multiply-add, so that every machine gives the same bytes.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define BOUNCELAB_VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define BOUNCELAB_VECTOR_CLONES
#endif

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
BOUNCELAB_VECTOR_CLONES void rotate(PoleValues& z, const PoleValues& e) {
  const std::size_t n = z.size();
  double* re = z.re.data();
  double* im = z.im.data();
  for (std::size_t p = 0; p < n; ++p) {
    const double re_before = re[p];
    re[p] = e.re[p] * re_before - e.im[p] * im[p];
    im[p] = e.re[p] * im[p] + e.im[p] * re_before;
  }
}

BOUNCELAB_VECTOR_CLONES void add_scaled(PoleValues& z, const PoleValues& k, double factor) {
  const std::size_t n = z.size();
  double* re = z.re.data();
  double* im = z.im.data();
  for (std::size_t p = 0; p < n; ++p) {
    re[p] += k.re[p] * factor;
    im[p] += k.im[p] * factor;
  }
}

/// One block of one resonator: out_j += Re((re + i im) (c_j + i s_j)).
BOUNCELAB_VECTOR_CLONES void add_rotation(double* out, const double* c, const double* s, double re, double im) {
  for (std::size_t j = 0; j < static_cast<std::size_t>(ResonatorBank::kBlock); ++j) out[j] += re * c[j] - im * s[j];
}

PoleValues product(const PoleValues& a, const PoleValues& b) {
  PoleValues result(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) result.set(k, a[k] * b[k]);
  return result;
}

/// Gauss points within one sample interval: two waves, each up to its own frequency, beat over it. With half the phase
/// theta of their product, 0.7 theta + 5.5 points leave 1e-9 (error term of the rule applied to exp(i theta x)).
int n_interval_nodes(double max_radps, double rate_hz) {
  const double theta = 0.5 * (kPi + max_radps / rate_hz);
  return static_cast<int>(std::ceil(0.7 * theta + 5.5));
}

double largest_frequency_radps(const std::vector<Complex>& poles) {
  double largest = 0.0;
  for (const Complex& pole : poles) largest = std::max(largest, std::abs(pole));
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
      memory_frames_(static_cast<std::int64_t>(std::log(1e11) / smallest_decay_per_s(poles_) * rate_hz)),
      interval_(gauss_legendre(n_interval_nodes(largest_frequency_radps(poles_), rate_hz), 0.0, 1.0)),
      pole_steps_(size()),
      step_(size()),
      block_step_(size()),
      kick_(interval_.nodes.size(), PoleValues(size())),
      table_(size() * static_cast<std::size_t>(kBlock)) {
  for (std::size_t p = 0; p < size(); ++p) {
    const Complex s = poles_[p] / rate_hz;
    pole_steps_.set(p, s);
    step_.set(p, std::exp(s));
    block_step_.set(p, std::exp(s * static_cast<double>(kBlock)));
    for (std::size_t i = 0; i < kick_.size(); ++i)
      kick_[i].set(p, interval_.weights[i] * std::exp(s * (1.0 - interval_.nodes[i])));
    for (std::int64_t j = 0; j < kBlock; ++j)
      table_.set(p * static_cast<std::size_t>(kBlock) + static_cast<std::size_t>(j),
                 std::exp(s * static_cast<double>(j)));
  }
}

double ResonatorBank::force(const Contact& contact, const PointImpulses& pulse, double frame) const {
  const double u = frame - contact.arrival_samples;
  double sum = 0.0;
  for (std::size_t q = 0; q < pulse.nodes.size(); ++q)
    sum += pulse.weights[q] * filter_(u - contact.duration_samples * pulse.nodes[q]);
  return contact.impulse * sum;
}

void ResonatorBank::step(PoleValues& z, std::span<const double> drive) const {
  rotate(z, step_);
  for (std::size_t i = 0; i < drive.size(); ++i) add_scaled(z, kick_[i], drive[i]);
}

ContactWave ResonatorBank::wave(const Contact& contact, const PoleValues& amplitudes, bool with_slopes) const {
  constexpr double kReach = ConverterFilter::kHalfWidth_samples;
  const auto first = static_cast<std::int64_t>(std::floor(contact.arrival_samples - kReach));
  const auto last = static_cast<std::int64_t>(std::ceil(contact.arrival_samples + contact.duration_samples + kReach));
  const std::int64_t end = (last + kBlock - 1) / kBlock * kBlock;
  const PointImpulses pulse = hertz_impulses(contact.duration_samples);

  // dy/dt = Re sum a_p (s_p z_p + g)
  const PoleValues slope_amplitudes = with_slopes ? product(amplitudes, pole_steps_) : PoleValues();
  const double direct = std::accumulate(amplitudes.re.begin(), amplitudes.re.end(), 0.0);

  ContactWave wave{first, {}, {}, PoleValues(size())};
  PoleValues z(size());
  std::vector<double> drive;
  for (std::int64_t n = first; n < end; ++n) {
    const auto frame = static_cast<double>(n);
    wave.samples.push_back(real_part_of_product(amplitudes, z));
    if (with_slopes)
      wave.slopes.push_back(real_part_of_product(slope_amplitudes, z) + direct * force(contact, pulse, frame));
    drive.clear();
    if (n < last)
      for (const double node : interval_.nodes) drive.push_back(force(contact, pulse, frame + node));
    step(z, drive);
  }
  wave.ringing = product(amplitudes, z);
  return wave;
}

void ResonatorBank::ring(PoleValues& state, double silence, std::span<double> out) const {
  constexpr auto kFrames = static_cast<std::size_t>(kBlock);
  for (std::size_t p = 0; p < size(); ++p) {
    double re = state.re[p], im = state.im[p];
    for (std::size_t frame = 0; frame < out.size(); frame += kFrames) {
      if (std::abs(re) + std::abs(im) < silence) {
        re = im = 0.0;
        break;
      }
      add_rotation(out.data() + frame, table_.re.data() + p * kFrames, table_.im.data() + p * kFrames, re, im);
      const double re_before = re;
      re = re * block_step_.re[p] - im * block_step_.im[p];
      im = re_before * block_step_.im[p] + im * block_step_.re[p];
    }
    state.re[p] = re;
    state.im[p] = im;
  }
}

void ResonatorBank::advance(PoleValues& state, std::int64_t n_frames) const {
  const double seconds = static_cast<double>(n_frames) / rate_hz_;
  for (std::size_t p = 0; p < size(); ++p) state.set(p, state[p] * std::exp(poles_[p] * seconds));
}

}  // namespace bouncelab
