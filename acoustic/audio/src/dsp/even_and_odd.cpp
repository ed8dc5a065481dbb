// SPDX-License-Identifier: GPL-3.0-or-later
#include "dsp/even_and_odd.hpp"

#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::audio {
namespace {

/// Eight complex numbers, in rising order.
[[gnu::always_inline]] inline void load_complex(const float* z, Lanes& re, Lanes& im) {
  Lanes a, b;
  load(z, a);
  load(z + kLanes, b);
  re = __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14);
  im = __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15);
}

/// The same in falling order.
[[gnu::always_inline]] inline void load_complex_reversed(const float* z, Lanes& re, Lanes& im) {
  Lanes a, b;
  load(z, a);
  load(z + kLanes, b);
  re = __builtin_shufflevector(a, b, 14, 12, 10, 8, 6, 4, 2, 0);
  im = __builtin_shufflevector(a, b, 15, 13, 11, 9, 7, 5, 3, 1);
}

[[gnu::always_inline]] inline void store_complex(const Lanes& re, const Lanes& im, float* z) {
  store(__builtin_shufflevector(re, im, 0, 8, 1, 9, 2, 10, 3, 11), z);
  store(__builtin_shufflevector(re, im, 4, 12, 5, 13, 6, 14, 7, 15), z + kLanes);
}

[[gnu::always_inline]] inline void store_complex_reversed(const Lanes& re, const Lanes& im, float* z) {
  store(__builtin_shufflevector(re, im, 7, 15, 6, 14, 5, 13, 4, 12), z);
  store(__builtin_shufflevector(re, im, 3, 11, 2, 10, 1, 9, 0, 8), z + kLanes);
}

[[gnu::always_inline]] inline void load_reversed(const float* from, Lanes& x) {
  load(from, x);
  x = __builtin_shufflevector(x, x, 7, 6, 5, 4, 3, 2, 1, 0);
}

[[gnu::always_inline]] inline void store_reversed(const Lanes& x, float* to) {
  store(__builtin_shufflevector(x, x, 7, 6, 5, 4, 3, 2, 1, 0), to);
}

/// Numbers k and h - k of a result, or many such pairs at once.
template <class Number>
struct Pair {
  Number re_low, im_low, re_high, im_high;
};

template <class Number>
[[gnu::always_inline]] inline void unpack_pair(const Number& low_re, const Number& low_im, const Number& high_re,
                                               const Number& high_im, const Number& cosine, const Number& sine,
                                               float scale, Pair<Number>& pair) {
  const Number even_re = low_re + high_re, even_im = low_im - high_im;
  const Number odd_re = low_im + high_im, odd_im = high_re - low_re;
  const Number turned_re = cosine * odd_re + sine * odd_im, turned_im = cosine * odd_im - sine * odd_re;
  pair.re_low = scale * (even_re + turned_re);
  pair.im_low = scale * (even_im + turned_im);
  pair.re_high = scale * (even_re - turned_re);
  pair.im_high = scale * (turned_im - even_im);
}

BOUNCELAB_VECTOR_CLONES void unpack_both(const float* z, const float* cosine, const float* sine, float scale,
                                         float* __restrict re, float* __restrict im, std::size_t h) {
  std::size_t k = 1;
  for (; k + kLanes <= h / 2; k += kLanes) {
    const std::size_t high = h - k - (kLanes - 1);
    Lanes low_re, low_im, high_re, high_im, c, s;
    load_complex(z + 2 * k, low_re, low_im);
    load_complex_reversed(z + 2 * high, high_re, high_im);
    load(cosine + k, c);
    load(sine + k, s);
    Pair<Lanes> pair;
    unpack_pair(low_re, low_im, high_re, high_im, c, s, scale, pair);
    store(pair.re_low, re + k);
    store(pair.im_low, im + k);
    store_reversed(pair.re_high, re + high);
    store_reversed(pair.im_high, im + high);
  }
  for (; k <= h / 2; ++k) {
    Pair<float> pair;
    unpack_pair(z[2 * k], z[2 * k + 1], z[2 * (h - k)], z[2 * (h - k) + 1], cosine[k], sine[k], scale, pair);
    re[h - k] = pair.re_high;
    im[h - k] = pair.im_high;
    re[k] = pair.re_low;
    im[k] = pair.im_low;
  }
}

template <class Number>
[[gnu::always_inline]] inline void pack_pair(const Number& low_re, const Number& low_im, const Number& high_re,
                                             const Number& high_im, const Number& cosine, const Number& sine,
                                             float scale, Pair<Number>& pair) {
  const Number even_re = low_re + high_re, even_im = low_im - high_im;
  const Number odd_re = low_re - high_re, odd_im = low_im + high_im;
  const Number turned_re = sine * odd_re + cosine * odd_im, turned_im = cosine * odd_re - sine * odd_im;
  pair.re_low = scale * (even_re - turned_re);
  pair.im_low = scale * (even_im + turned_im);
  pair.re_high = scale * (even_re + turned_re);
  pair.im_high = scale * (turned_im - even_im);
}

BOUNCELAB_VECTOR_CLONES void pack_both(const float* re, const float* im, const float* cosine, const float* sine,
                                       float scale, float* __restrict z, std::size_t h) {
  std::size_t k = 1;
  for (; k + kLanes <= h / 2; k += kLanes) {
    const std::size_t high = h - k - (kLanes - 1);
    Lanes low_re, low_im, high_re, high_im, c, s;
    load(re + k, low_re);
    load(im + k, low_im);
    load_reversed(re + high, high_re);
    load_reversed(im + high, high_im);
    load(cosine + k, c);
    load(sine + k, s);
    Pair<Lanes> pair;
    pack_pair(low_re, low_im, high_re, high_im, c, s, scale, pair);
    store_complex(pair.re_low, pair.im_low, z + 2 * k);
    store_complex_reversed(pair.re_high, pair.im_high, z + 2 * high);
  }
  for (; k <= h / 2; ++k) {
    Pair<float> pair;
    pack_pair(re[k], im[k], re[h - k], im[h - k], cosine[k], sine[k], scale, pair);
    z[2 * (h - k)] = pair.re_high;
    z[2 * (h - k) + 1] = pair.im_high;
    z[2 * k] = pair.re_low;
    z[2 * k + 1] = pair.im_low;
  }
}

}  // namespace

void unpack_even_and_odd(const float* z, const float* cosine, const float* sine, float scale, float* re, float* im,
                         std::size_t h) {
  unpack_both(z, cosine, sine, scale, re, im, h);
}

void pack_even_and_odd(const float* re, const float* im, const float* cosine, const float* sine, float scale, float* z,
                       std::size_t h) {
  pack_both(re, im, cosine, sine, scale, z, h);
}

}  // namespace bouncelab::audio
