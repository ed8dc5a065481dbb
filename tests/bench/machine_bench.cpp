// SPDX-License-Identifier: GPL-3.0-or-later
/// machine_bench: what one core of this machine can do at most, as the roofline of docs/performance.md takes it: bytes
/// copied in memory, the latency of a byte that is in no cache, the first byte written to a page, multiplications and
/// additions a second, FFTW's Fourier transforms, bytes read from a file that is in memory, and their checksum.
#include <fcntl.h>
#include <fftw3.h>
#include <nettle/sha2.h>
#include <sys/mman.h>
#include <unistd.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "bench_lines.hpp"

namespace {

using bouncelab::bench::least_s;
using bouncelab::bench::print_line;

volatile double sink;  // what is not used is not computed

// Ten independent chains of fused multiplications and additions: more than latency times units of today's processors.
// They begin at different values, or the compiler takes equal ones for one.
constexpr int kChains = 10, kSteps = 20000;

#if defined(__x86_64__)
#define BOUNCELAB_FMA_CHAINS(name, isa, Vector, Number, set1, fmadd, storeu)                \
  [[gnu::target(isa), gnu::noinline]] double name() {                                       \
    const Vector a = set1(Number(0.999)), b = set1(Number(1e-3));                           \
    Vector x0 = set1(0), x1 = set1(1), x2 = set1(2), x3 = set1(3), x4 = set1(4);            \
    Vector x5 = set1(5), x6 = set1(6), x7 = set1(7), x8 = set1(8), x9 = set1(9);            \
    for (int k = 0; k < kSteps; ++k) {                                                      \
      x0 = fmadd(x0, a, b), x1 = fmadd(x1, a, b), x2 = fmadd(x2, a, b);                     \
      x3 = fmadd(x3, a, b), x4 = fmadd(x4, a, b), x5 = fmadd(x5, a, b);                     \
      x6 = fmadd(x6, a, b), x7 = fmadd(x7, a, b), x8 = fmadd(x8, a, b);                     \
      x9 = fmadd(x9, a, b);                                                                 \
    }                                                                                       \
    Number out[sizeof(Vector) / sizeof(Number)];                                            \
    storeu(out, (x0 + x1 + x2 + x3 + x4) + (x5 + x6 + x7 + x8 + x9));                       \
    return static_cast<double>(std::accumulate(std::begin(out), std::end(out), Number(0))); \
  }
BOUNCELAB_FMA_CHAINS(floats_512, "avx512f", __m512, float, _mm512_set1_ps, _mm512_fmadd_ps, _mm512_storeu_ps)
BOUNCELAB_FMA_CHAINS(doubles_512, "avx512f", __m512d, double, _mm512_set1_pd, _mm512_fmadd_pd, _mm512_storeu_pd)
BOUNCELAB_FMA_CHAINS(floats_256, "avx2,fma", __m256, float, _mm256_set1_ps, _mm256_fmadd_ps, _mm256_storeu_ps)
BOUNCELAB_FMA_CHAINS(doubles_256, "avx2,fma", __m256d, double, _mm256_set1_pd, _mm256_fmadd_pd, _mm256_storeu_pd)
#undef BOUNCELAB_FMA_CHAINS
#endif

/// Without vectors, for processors that the above does not know.
template <class Number>
[[gnu::noinline]] double plain_chains() {
  Number x[kChains];
  std::iota(std::begin(x), std::end(x), Number(0));
  for (int k = 0; k < kSteps; ++k)
    for (Number& value : x) value = value * Number(0.999) + Number(1e-3);
  return static_cast<double>(std::accumulate(std::begin(x), std::end(x), Number(0)));
}

template <class Chains>
void print_flops(const char* what, Chains chains, int n_lanes) {
  const double n_flop = 2.0 * kChains * kSteps * n_lanes;
  print_line("machine", "one core", what, n_flop / least_s([&] { sink = chains(); }, 100), "FLOP/s");
}

void print_peak_flops() {
  const char* const floats = "multiplications and additions, float";
  const char* const doubles = "multiplications and additions, double";
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f")) {
    print_flops(floats, floats_512, 16);
    print_flops(doubles, doubles_512, 8);
    return;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    print_flops(floats, floats_256, 8);
    print_flops(doubles, doubles_256, 4);
    return;
  }
#endif
  print_flops(floats, plain_chains<float>, 1);
  print_flops(doubles, plain_chains<double>, 1);
}

/// By memcpy between buffers that no cache holds; read and written bytes both count.
void print_bandwidth() {
  constexpr std::size_t kBytes = std::size_t{256} << 20;
  std::vector<char> from(kBytes, 1), to(kBytes, 2);
  const double seconds = least_s([&] { std::memcpy(to.data(), from.data(), kBytes); }, 10);
  sink = to[kBytes / 2];
  print_line("machine", "one core", "memory, copied", 2.0 * kBytes / seconds, "B/s");
}

/// Of 64 bytes after the other, each of which says where the next lie: a cycle through so much memory in random order.
void print_latency(std::size_t n_mib) {
  struct alignas(64) Line {
    std::uint32_t next = 0;
  };
  constexpr int kReads = 1000000;
  const std::size_t n_lines = (n_mib << 20) / sizeof(Line);
  std::vector<Line> lines(n_lines);
  std::vector<std::uint32_t> order(n_lines);
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  for (std::size_t k = 0; k < n_lines; ++k) lines[order[k]].next = order[(k + 1) % n_lines];
  std::uint32_t at = 0;
  const double seconds = least_s(
      [&] {
        for (int k = 0; k < kReads; ++k) at = lines[at].next;
      },
      5);
  sink = at;
  print_line("machine", "one core", "latency in " + std::to_string(n_mib) + " MiB", seconds / kReads, "s");
}

/// Real to complex, 2.5 n log2 n operations each, as the authors of FFTW count.
void print_fftw() {
  for (const int n : {1024, 4096, 65536}) {
    float* real = fftwf_alloc_real(static_cast<std::size_t>(n));
    fftwf_complex* complex = fftwf_alloc_complex(static_cast<std::size_t>(n) / 2 + 1);
    std::fill(real, real + n, 0.5F);
    const fftwf_plan plan = fftwf_plan_dft_r2c_1d(n, real, complex, FFTW_ESTIMATE);
    const double seconds = least_s([&] { fftwf_execute(plan); });
    print_line("machine", "one core", "FFTW, float, n = " + std::to_string(n), 2.5 * n * std::log2(n) / seconds,
               "FLOP/s");
    fftwf_destroy_plan(plan);
    fftwf_free(real);
    fftwf_free(complex);
  }
}

/// The system sets a page to zero when it is first written to: memory of which pieces of any size are taken anew.
void print_new_pages() {
  constexpr std::size_t kPage = 4096, kPages = 4096, kBytes = kPage * kPages;
  const double seconds = least_s(
      [&] {
        void* memory = ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) return;
        for (std::size_t at = 0; at < kBytes; at += kPage) static_cast<volatile char*>(memory)[at] = 1;
        ::munmap(memory, kBytes);
      },
      10);
  print_line("machine", "one core", "a page of memory, first written to", seconds / kPages, "s");
}

void print_checksum() {
  const std::vector<std::uint8_t> bytes(std::size_t{1} << 18, 1);
  sha256_ctx state;
  sha256_init(&state);
  const double seconds = least_s([&] { sha256_update(&state, bytes.size(), bytes.data()); });
  print_line("machine", "one core", "SHA-256 of bytes in the cache", static_cast<double>(bytes.size()) / seconds,
             "B/s");
}

void print_reading() {
  constexpr std::size_t kBytes = std::size_t{64} << 20, kAtOnce = std::size_t{1} << 18;
  const auto path = std::filesystem::temp_directory_path() / ("machine_bench_" + std::to_string(::getpid()));
  std::vector<char> buffer(kAtOnce, 1);
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL, 0600);
  if (file < 0) return;
  std::filesystem::remove(path);
  bool good = true;
  for (std::size_t at = 0; at < kBytes; at += kAtOnce)
    good &= ::write(file, buffer.data(), kAtOnce) == static_cast<ssize_t>(kAtOnce);
  const double seconds = least_s(
      [&] {
        for (std::size_t at = 0; at < kBytes; at += kAtOnce)
          good &= ::pread(file, buffer.data(), kAtOnce, static_cast<off_t>(at)) == static_cast<ssize_t>(kAtOnce);
      },
      10);
  ::close(file);
  if (good) print_line("machine", "one core", "file in memory, read", kBytes / seconds, "B/s");
}

}  // namespace

int main() {
  print_peak_flops();
  print_fftw();
  print_bandwidth();
  for (const std::size_t n_mib : {8, 64, 256}) print_latency(n_mib);
  print_new_pages();
  print_reading();
  print_checksum();
}
