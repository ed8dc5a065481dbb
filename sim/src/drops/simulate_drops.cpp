// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "drops/drop.hpp"

namespace bouncelab::sim {
namespace {

/// Drops that take turns, until all are over.
void simulate_in_turn(const SimulationConfig& config, const Envelope& envelope, std::span<const std::int64_t> numbers,
                      std::vector<DropResult>& results) {
  std::vector<Drop> drops;
  drops.reserve(numbers.size());
  for (const std::int64_t number : numbers) drops.emplace_back(config, envelope, number);
  std::vector<Drop*> flying, searching;
  for (Drop& drop : drops) flying.push_back(&drop);
  while (!flying.empty()) {
    for (Drop* drop : flying) drop->begin_flight();
    searching = flying;
    while (!searching.empty()) std::erase_if(searching, [](Drop* drop) { return drop->find_leaf(); });
    for (Drop* drop : flying) drop->end_flight();
    std::erase_if(flying, [](const Drop* drop) { return drop->is_over(); });
  }
  for (Drop& drop : drops) results.push_back(std::move(drop).result());
}

}  // namespace

std::vector<DropResult> simulate_drops(const SimulationConfig& config, const Envelope& envelope,
                                       std::span<const std::int64_t> numbers) {
  std::vector<DropResult> results;
  results.reserve(numbers.size());
  for (std::size_t first = 0; first < numbers.size(); first += kDropsInTurn) {
    const auto some = numbers.subspan(first, std::min(kDropsInTurn, numbers.size() - first));
    simulate_in_turn(config, envelope, some, results);
  }
  return results;
}

DropResult simulate_drop(const SimulationConfig& config, const Envelope& envelope, std::int64_t drop) {
  return std::move(simulate_drops(config, envelope, std::array{drop}).front());
}

}  // namespace bouncelab::sim
