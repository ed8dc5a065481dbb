// SPDX-License-Identifier: GPL-3.0-or-later
/// kernels_bench: the hand-made loops of bouncelab::audio against plain ones compiled alike and libsndfile's decoder.
/// Prints seconds of one call of each; they take turns, and the least of many counts.
#include <sndfile.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "bench_lines.hpp"
#include "bouncelab/audio/audio.hpp"
#include "bouncelab/audio/dsp/kernels.hpp"

namespace {

using namespace bouncelab;
using namespace bouncelab::audio;
using Floats = std::vector<float>;
using Doubles = std::vector<double>;

void print_row(const char* kernel, const char* baseline, const std::function<void()>& ours,
               const std::function<void()>& theirs) {
  const bench::Pair least = bench::alternating(ours, theirs);
  bench::print_line("kernels", kernel, "bouncelab", least.ours_s, "s");
  bench::print_line("kernels", kernel, baseline, least.baseline_s, "s");
}

volatile double sink;  // what is not used is not computed

template <class Number>
std::vector<Number> noise(std::size_t n) {
  std::mt19937 generator(1);
  std::normal_distribution<Number> normal;
  std::vector<Number> x(n);
  for (Number& value : x) value = normal(generator);
  return x;
}

// Baselines: as one would write them.

[[gnu::noinline]] void filter_plainly(const Floats& x, const Floats& taps, Floats& out) {
  std::fill(out.begin(), out.end(), 0.0F);
  for (std::size_t k = 0; k < taps.size(); ++k)
    for (std::size_t n = 0; n < out.size(); ++n) out[n] += taps[k] * x[n + k];
}

template <class Number>
[[gnu::noinline]] void add_scaled_plainly(Number* to, Number factor, const Number* x, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) to[k] += factor * x[k];
}

[[gnu::noinline]] void multiply_plainly(const double* a, const double* b, double* product, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k) product[k] = a[k] * b[k];
}

[[gnu::noinline]] void shift_plainly(const Spectrum& a, double angle, Spectrum& out) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    const auto z =
        std::complex(a.re[k], a.im[k]) * std::polar(1.0F, static_cast<float>(angle * static_cast<double>(k)));
    out.re[k] = z.real();
    out.im[k] = z.imag();
  }
}

void print_sums() {
  const Floats a = noise<float>(4096), b = noise<float>(4096);
  const Doubles c = noise<double>(300), d = noise<double>(300);
  print_row(
      "dot, 4096 floats", "std::inner_product", [&] { sink = dot(a, b); },
      [&] { sink = std::inner_product(a.begin(), a.end(), b.begin(), 0.0F); });
  print_row(
      "dot, 300 doubles", "std::inner_product", [&] { sink = dot(c.data(), d.data(), c.size()); },
      [&] { sink = std::inner_product(c.begin(), c.end(), d.begin(), 0.0); });
  print_row(
      "largest, 4096 floats", "std::max_element", [&] { sink = largest(a); },
      [&] { sink = *std::max_element(a.begin(), a.end()); });
}

void print_products() {
  Floats a = noise<float>(2049);
  const Floats b = noise<float>(2049);
  Doubles c = noise<double>(300), product(300);
  const Doubles d = noise<double>(300);
  print_row(
      "add_scaled, 2049 floats", "plain loop", [&] { add_scaled(a.data(), 1e-9F, b.data(), a.size()); },
      [&] { add_scaled_plainly(a.data(), 1e-9F, b.data(), a.size()); });
  print_row(
      "add_scaled, 300 doubles", "plain loop", [&] { add_scaled(c.data(), 1e-9, d.data(), c.size()); },
      [&] { add_scaled_plainly(c.data(), 1e-9, d.data(), c.size()); });
  print_row(
      "multiply, 300 doubles", "plain loop", [&] { multiply(c.data(), d.data(), product.data(), c.size()); },
      [&] { multiply_plainly(c.data(), d.data(), product.data(), c.size()); });
}

void print_filter() {
  for (const std::size_t n_taps : {34, 50}) {
    const Floats taps = noise<float>(n_taps), x = noise<float>(8192 + n_taps);
    Floats out(8192);
    char name[40];
    std::snprintf(name, sizeof name, "correlate, 8192 by %zu taps", n_taps);
    print_row(
        name, "a plain loop over samples in one over taps", [&] { correlate(x, taps, out); },
        [&] { filter_plainly(x, taps, out); });
  }
}

void print_phase_shift() {
  const Spectrum a{noise<float>(2049), noise<float>(2049)};
  Spectrum out = a;
  print_row(
      "phase_shift, 2049 bins", "std::polar for each bin", [&] { phase_shift(a, 0.1, out); },
      [&] { shift_plainly(a, 0.1, out); });
}

void print_decoding(SampleEncoding encoding, const char* name) {
  constexpr std::int64_t kFrames = 2000000, kAtOnce = 1 << 14;
  const auto path = std::filesystem::temp_directory_path() / ("kernels_bench_" + std::to_string(::getpid()) + ".wav");
  {
    AudioWriter writer(path, {96000, 1, encoding}, kFrames, true);
    Doubles samples = noise<double>(kFrames);
    for (double& x : samples) x *= 0.1;
    writer.write(samples);
    writer.commit();
  }
  Floats out(kAtOnce);
  AudioReader reader(path);
  SF_INFO info{};
  SNDFILE* file = sf_open(path.c_str(), SFM_READ, &info);
  print_row(
      name, "sf_readf_float",
      [&] {
        for (std::int64_t at = 0; at + kAtOnce <= kFrames; at += kAtOnce) reader.read(at, 0, out);
      },
      [&] {
        sf_seek(file, 0, SEEK_SET);
        for (std::int64_t at = 0; at + kAtOnce <= kFrames; at += kAtOnce) sf_readf_float(file, out.data(), kAtOnce);
      });
  sf_close(file);
  std::filesystem::remove(path);
}

}  // namespace

int main() {
  print_sums();
  print_products();
  print_filter();
  print_phase_shift();
  print_decoding(SampleEncoding::pcm16, "AudioReader::read, 2e6 of 16 bits");
  print_decoding(SampleEncoding::pcm24, "AudioReader::read, 2e6 of 24 bits");
}
