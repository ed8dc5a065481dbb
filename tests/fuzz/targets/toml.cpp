// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

#include "options/config_file.hpp"
#include "options/numbers.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

/// A command with an option of each kind.
struct Command {
  Command() : app("", "simulate") {
    app.add_option("--drops", drops);
    app.add_option("--snr-db", snr_db);
    app.add_option("--radius-law", radius_law);
    cli::add_list(app, "--height", height, "X,Y", 1, 2, 0.0, 10.0, "");
    app.add_flag("--force", force);
    app.add_option("--config", config);
  }
  int drops = 0;
  double snr_db = 0.0;
  std::string radius_law, config;
  std::vector<double> height;
  bool force = false;
  CLI::App app;
};

std::optional<cli::ConfigSection> section_named(const std::string& name) {
  const std::vector<std::string> own{"drops", "snr-db", "radius-law", "height", "force"};
  if (name == "simulate") return cli::ConfigSection{own, own};
  if (name == "detect") return cli::ConfigSection{{"snr-db", "height"}, {{"snr-db"}}};
  if (name == "fit") return cli::ConfigSection{{"nodes"}, std::nullopt};
  return std::nullopt;
}

}  // namespace

void run(Bytes input) {
  static const Command command;
  std::vector<cli::ConfigOption> options;
  if (!accepts([&] { options = cli::config_options(text_of(input), "input", command.app, section_named); })) return;
  for (const cli::ConfigOption& option : options) {
    require(command.app.get_option_no_throw("--" + option.name) != nullptr, "a key is an option of the command");
    require(!option.values.empty(), "an option has values");
  }
}

}  // namespace bouncelab::fuzz
