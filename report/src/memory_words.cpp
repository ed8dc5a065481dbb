// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/text.hpp"
#include "bouncelab/report/answer.hpp"
#include "bouncelab/report/notes.hpp"

namespace bouncelab::report {
using namespace fit;
namespace {

std::string describe_tests(const MemoryFit& memory) {
  std::string text;
  if (memory.anderson_darling)
    text +=
        formatted("Anderson-Darling test of the probability transforms p = %.2g, ", memory.anderson_darling->p_value);
  text += formatted("offset and width of the scatter by one roughness p = %.2g", memory.mechanism.p_value);
  text += formatted(", as rough at every speed p = %.2g", memory.by_speed.p_value);
  if (memory.between_drops) text += formatted(", drops alike p = %.2g", memory.between_drops->p_value);
  return text;
}

}  // namespace

std::string objections_in_words(const MemoryFit& memory) {
  std::string text;
  for (const std::string& one : texts_of(memory.objections)) text += (text.empty() ? "" : "; ") + one;
  return text;
}

std::string in_words(const MemoryFit& memory) {
  if (memory.status != FitStatus::ok) return "memory could not be fitted: " + objections_in_words(memory);
  if (!memory.holds)
    return "the fit with memory does not hold for these impacts: " + objections_in_words(memory) +
           "; use the curve ε(v) of the fit with independent impacts";
  std::string text = "the fluctuations remember those before them, as a rough ball's do: ";
  if (memory.loglik_independent)
    text += formatted("log-likelihood %.1f above that of independent impacts, ",
                      memory.loglik - *memory.loglik_independent);
  const Estimate leak = leak_of(memory);
  return text + describe_tests(memory) + "; share of the reservoir that an impact loses " +
         fit::in_words(leak.value, leak.se) + formatted(" (p = %.2g against none)", memory.leak.p_value);
}

std::string in_words(const Roughness& r) {
  std::string text = formatted("q = %.3g", r.q.value);
  if (r.q.se) text += formatted(" ± %.1g", *r.q.se);
  if (r.q.ci95) text += formatted(" (95 %%: %.3g to %.3g)", r.q.ci95->lo, r.q.ci95->hi);
  return text + formatted(", rms tilt of the contact's normal %.2g degrees without slip", r.rms_tilt_no_slip_deg);
}

}  // namespace bouncelab::report
