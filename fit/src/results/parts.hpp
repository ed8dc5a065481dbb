// SPDX-License-Identifier: GPL-3.0-or-later
/// What the descriptions of several results share.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/fit/memory_fit.hpp"

namespace bouncelab::fit {

/// `name` where the fit has a result, else not known.
template <auto Member>
constexpr bouncelab::Member where_ok(std::string_view name, std::string_view text) {
  using S = decltype(describe_detail::owner_of(Member));
  bouncelab::Member made = member<Member>(name, text);
  made.place = describe_detail::itself;
  made.read = [](const void* object) {
    const S& s = *static_cast<const S*>(object);
    return s.status == FitStatus::ok ? value_of(std::invoke(Member, s)) : Value{};
  };
  return made;
}

/// The names of parameters, and each under its own.
Object by_name(const std::vector<NamedEstimate>& parameters);
/// By the address of the parameters, or those on the way to them, as member() has it.
template <auto First, auto... Further>
constexpr Member estimates_by_name() {
  using namespace describe_detail;
  return computed(
      "",
      [](const decltype(owner_of(First))& s) {
        const std::vector<NamedEstimate>& parameters = reach<First, Further...>(s);
        Object all = by_name(parameters);
        std::vector<std::string> names;
        for (const NamedEstimate& p : parameters) names.push_back(p.name);
        all.emplace_back("parameters", std::move(names));
        return all;
      },
      "`A2`, `A4`, `A5` ... or `gamma` or `eps`: an estimate each; `parameters`: their names, in the order of "
      "matrices");
}

/// The roughness where the fit has a result, else not known.
Value roughness_if_fitted(const MemoryFit& memory);

}  // namespace bouncelab::fit
