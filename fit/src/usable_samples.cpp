// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/usable_samples.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "bouncelab/core/ball.hpp"

namespace bouncelab::fit {
namespace {

/// Whether the ball that is named touches the plate for most of the time that a bounce of the sample lasts: what is
/// left of a flight then is the error of the contact time.
class ContactMostOfBounce {
 public:
  bool operator()(const RestitutionSample& s) {
    const SampleConditions& said = s.conditions;
    if (!said.ball || !said.gravity_mps2 || said.contact_time_corrected) return false;
    if (said.ball != ball_ || said.plate != plate_)
      ball_ = said.ball, plate_ = said.plate, contact_ = contact_duration(*ball_, plate_);
    return contact_ && 2.0 * contact_->at(s.v_mps) >= 2.0 * s.v_mps / *said.gravity_mps2 * std::clamp(s.eps, 0.0, 1.0);
  }

 private:
  std::optional<Ball> ball_;
  std::optional<Material> plate_;
  std::optional<ContactDuration> contact_;  ///< of that ball on that plate
};

/// Why a sample cannot be used; empty: it can. The first flag names the reason.
std::string_view reason_to_leave_out(const RestitutionSample& s, ContactMostOfBounce& is_mostly_contact) {
  if (!std::isfinite(s.v_mps) || !std::isfinite(s.eps)) return "not_finite";
  if (!(s.v_mps > 0.0)) return "speed_not_positive";
  if (s.flags.empty() && is_mostly_contact(s)) return "contact_most_of_bounce";
  return s.flags.first_word();
}

}  // namespace

PartOfSamples usable_samples(const RestitutionSamples& samples, LeftOut& left_out) {
  std::vector<std::size_t> unusable;
  ContactMostOfBounce is_mostly_contact;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::string_view reason = reason_to_leave_out(samples[k], is_mostly_contact);
    if (reason.empty()) continue;
    unusable.push_back(k);
    ++left_out.n[std::string(reason)];
    left_out.first.try_emplace(std::string(reason), k + 1);
  }
  return {samples, unusable};
}

PartOfSamples::PartOfSamples(const RestitutionSamples& all, const std::vector<std::size_t>& left_out) : all_(all) {
  if (left_out.empty()) return;
  part_.emplace();
  part_->reserve(all.size() - left_out.size());
  auto next = left_out.begin();
  for (std::size_t k = 0; k < all.size(); ++k)
    if (next != left_out.end() && *next == k)
      ++next;
    else
      part_->push_back(all[k]);
}

}  // namespace bouncelab::fit
