// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/template_training.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "template/template_model.hpp"

namespace bouncelab::detection {
namespace {

double template_length_s(const std::vector<Candidate>& impacts) {
  std::size_t n_close = 0;
  std::size_t n_far = 0;
  for (std::size_t k = 0; k + 1 < impacts.size(); ++k) {
    n_close += impacts[k + 1].t_s - impacts[k].t_s < kTemplate.close_s ? 1 : 0;
    n_far += impacts[k + 1].t_s - impacts[k].t_s > 2.0 * kTemplate.long_s ? 1 : 0;
  }
  return n_close >= kTemplate.many_close && n_far >= kTemplate.many_isolated ? kTemplate.long_s : kTemplate.short_s;
}

std::vector<double> taper_of(const TemplateWindow& window) {
  const auto fall = static_cast<std::size_t>(window.samples(kTemplate.taper_s));
  const auto rise = static_cast<std::size_t>(window.samples(0.25 * kTemplate.lead_s)) + 1;
  const auto part_of_sine = [](std::size_t n, std::size_t of) {
    return square(sin(0.5 * kPi * static_cast<double>(n) / static_cast<double>(of)));
  };
  std::vector<double> taper(window.n_template, 1.0);
  for (std::size_t n = 0; n < std::min(rise, taper.size()); ++n) taper[n] *= part_of_sine(n, rise);
  for (std::size_t left = 1; left < fall && left <= taper.size(); ++left)
    taper[taper.size() - left] *= part_of_sine(left, fall);
  return taper;
}

}  // namespace

std::int64_t TemplateWindow::samples(double duration_s) const { return std::llround(duration_s * rate_hz); }

TemplateWindow template_window(const audio::AudioSource& sound, const std::vector<Candidate>& impacts) {
  const double length_s = template_length_s(impacts);
  TemplateWindow w{sound.rate_hz, 0, 0, {}};
  w.n_window = std::bit_ceil(
      static_cast<std::size_t>(w.samples(kTemplate.lead_s + length_s + 2.0 * kTemplate.rough_time_error_s)));
  w.n_template = std::min(w.n_window, static_cast<std::size_t>(w.samples(kTemplate.lead_s + length_s)));
  w.taper = taper_of(w);
  return w;
}

std::vector<std::size_t> choose_training_impacts(const std::vector<Candidate>& impacts,
                                                 const std::vector<bool>& clipped) {
  const double length_s = template_length_s(impacts);
  std::vector<std::size_t> isolated;
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < impacts.size(); ++k) {
    all.push_back(k);
    const bool next_far =
        k + 1 == impacts.size() || impacts[k + 1].t_s - impacts[k].t_s > length_s + 2.0 * kTemplate.rough_time_error_s;
    const bool last_far = k == 0 || impacts[k].t_s - impacts[k - 1].t_s > length_s;
    if (next_far && last_far) isolated.push_back(k);
  }
  std::vector<std::size_t> unclipped = isolated;
  std::erase_if(unclipped, [&](std::size_t k) { return clipped[k]; });
  if (std::ssize(unclipped) >= kTemplate.fewest_unclipped) isolated = unclipped;
  std::vector<std::size_t>& chosen = isolated.size() >= kTemplate.few_isolated ? isolated : all;
  const auto stronger = [&](std::size_t a, std::size_t b) { return impacts[a].amplitude > impacts[b].amplitude; };
  if (chosen.size() > kTemplate.most_training) {
    std::nth_element(chosen.begin(), chosen.begin() + kTemplate.most_training, chosen.end(), stronger);
    chosen.resize(kTemplate.most_training);
  }
  std::sort(chosen.begin(), chosen.end(), stronger);
  return chosen;
}

std::vector<float> coherence_weight(const audio::Spectrum& a, double weight_a, const audio::Spectrum& b,
                                    double weight_b) {
  const std::size_t n = a.size();
  std::vector<double> common(n + 1, 0.0), all(n + 1, 0.0);  // running sums
  const double weight = weight_a + weight_b;
  for (std::size_t k = 0; k < n; ++k) {
    const double re = static_cast<double>(a.re[k]) + b.re[k];
    const double im = static_cast<double>(a.im[k]) + b.im[k];
    const double product = static_cast<double>(a.re[k]) * b.re[k] + static_cast<double>(a.im[k]) * b.im[k];
    common[k + 1] = common[k] + product / (weight_a * weight_b);
    all[k + 1] = all[k] + (re * re + im * im) / (weight * weight);
  }
  std::vector<float> weights(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t from = k > kTemplate.coherence_bins ? k - kTemplate.coherence_bins : 0;
    const std::size_t to = std::min(n, k + kTemplate.coherence_bins + 1);
    const double ratio = (common[to] - common[from]) / (all[to] - all[from] + 1e-30);
    weights[k] = static_cast<float>(
        std::clamp((ratio - kTemplate.coherence_of_noise) / (1.0 - kTemplate.coherence_of_noise), 0.0, 1.0));
  }
  return weights;
}

}  // namespace bouncelab::detection
