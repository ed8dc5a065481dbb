// SPDX-License-Identifier: GPL-3.0-or-later
/// The command line, read by CLI11.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "options/commands.hpp"

namespace bouncelab::cli {

/// A command line that is not understood.
struct WrongUsage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Sets options from arguments as they are typed: --drops 8, --drops=8, --drag, positional ones.
/// @return what was given
/// @throws WrongUsage  in one line: what is wrong with which option, or which one was probably meant
Given set_options(const std::vector<Section>& sections, const std::vector<std::string>& arguments);

/// What --help of a command shows; all of its options, or the common ones.
std::string help_of(const Command& command, bool all);
/// What --help shows: the commands.
std::string help_of_all();

}  // namespace bouncelab::cli
