// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>

#include "bouncelab/loop/scatter_theory.hpp"

namespace bouncelab::cli {

/// `theory` of a loop's summary.json (docs/formats.md).
nlohmann::ordered_json scatter_json(const loop::ScatterTheory& theory);

}  // namespace bouncelab::cli
