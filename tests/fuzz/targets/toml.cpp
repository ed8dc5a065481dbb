// SPDX-License-Identifier: GPL-3.0-or-later
#include <CLI/CLI.hpp>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "options/config_file.hpp"
#include "options/numbers.hpp"
#include "options/toml_entries.hpp"
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
  using Use = cli::ConfigSection::Use;
  if (name == "simulate") return cli::ConfigSection{Use::own, {}, {}};
  if (name == "detect") return cli::ConfigSection{Use::stage, {"snr-db", "height"}, {"snr-db"}};
  if (name == "fit") return cli::ConfigSection{Use::other, {"nodes"}, {}};
  return std::nullopt;
}

void check(const cli::TomlEntries& toml) {
  for (const cli::TomlEntry& entry : toml.entries) {
    require(entry.line > 0 && entry.depth >= 0 && entry.depth <= 2, "an entry has a line and a depth");
    require(!entry.values.empty(), "an entry has values");
    require(std::none_of(entry.values.begin(), entry.values.end(), [](const auto& v) { return v.empty(); }),
            "no list is empty");
  }
}

}  // namespace

void run(Bytes input) {
  static const Command command;
  cli::TomlEntries toml;
  if (!accepts([&] { toml = cli::toml_entries(text_of(input), "input"); })) return;
  check(toml);
  std::vector<cli::ConfigOption> options;
  if (!accepts([&] { options = cli::config_options(toml, "input", command.app, section_named); })) return;
  require(options.size() <= toml.entries.size(), "each option comes from an entry");
  for (const cli::ConfigOption& option : options) {
    require(command.app.get_option_no_throw("--" + option.name) != nullptr, "a key is an option of the command");
    require(!option.values.empty(), "an option has values");
  }
}

}  // namespace bouncelab::fuzz
