// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/ball_options.hpp"

#include <CLI/CLI.hpp>

#include "bouncelab/core/error.hpp"

namespace bouncelab::cli {
namespace {

/// What is wrong with a description is said where it stands, on the command line or in the configuration file.
template <class Value>
CLI::Validator description(Value (*from_text)(const std::string&)) {
  return {[from_text](std::string& text) -> std::string {
            try {
              from_text(text);
            } catch (const InvalidArgument& error) {
              return error.what();
            }
            return "";
          },
          ""};
}

}  // namespace

void add_ball_options(CLI::App& app, BallChoice& choice, const std::string& unnamed) {
  const std::string otherwise = unnamed.empty() ? "" : "; default: " + unnamed;
  app.add_option("--ball", choice.ball,
                 "The ball: table-tennis, golf ...; steel:6mm, glass:16mm ... (material and DIAMETER; steel:r=3mm: "
                 "radius); or numbers, radius=20mm,mass=2.7g,inertia=0.65. bouncelab balls lists them" +
                     otherwise)
      ->type_name("BALL")
      ->check(description(ball_from_text));
  app.add_option("--plate", choice.plate,
                 "What it falls on: glass, steel, concrete ...; or E=70GPa,nu=0.22,density=2500" + otherwise)
      ->type_name("PLATE")
      ->check(description(plate_from_text));
}

}  // namespace bouncelab::cli
