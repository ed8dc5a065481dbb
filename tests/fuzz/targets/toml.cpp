// SPDX-License-Identifier: GPL-3.0-or-later
#include <string>
#include <vector>

#include "options/commands.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

/// Options of each kind.
struct Options {
  int drops = 0;
  double snr_db = 0.0;
  std::string radius_law;
  std::vector<double> height, nodes;
  bool force_it = false;
};

Description members_of(const Options*) {
  static constexpr Member options[]{member<&Options::drops>("drops", "").within(1, 100),
                                    member<&Options::snr_db>("snr_db", ""),
                                    member<&Options::radius_law>("radius_law", ""),
                                    member<&Options::height>("height", "").with_commas("X,Y", 1, 2).within(0.0, 10.0),
                                    member<&Options::nodes>("nodes", ""),
                                    member<&Options::force_it>("force_it", "")};
  return options;
}

template <int kCommand>
cli::Command command() {
  static Options options;
  const std::string name = kCommand == 0 ? "loop" : kCommand == 1 ? "simulate" : "fit";
  return {name, "", "", "", {"simulate", "report"}, false, {}, {options::section_of(options, "", {"simulate"})}};
}

const std::vector<cli::Command>& commands() {
  static const std::vector<cli::Command> all{command<0>(), command<1>(), command<2>()};
  return all;
}

}  // namespace

void run(Bytes input) {
  static const cli::Command loop = command<0>();
  std::vector<cli::ConfigOption> options;
  if (!accepts([&] { options = cli::config_options(text_of(input), "input", loop, commands()); })) return;
  for (const cli::ConfigOption& option : options) {
    require(cli::option_named(loop.sections, option.name).has_value() || option.name == "seed" ||
                option.name == "threads" || option.name == "json" || option.name == "quiet" || option.name == "force",
            "a key is an option of the command, or of all");
    require(!option.values.empty(), "an option has values");
  }
}

}  // namespace bouncelab::fuzz
