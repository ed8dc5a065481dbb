// SPDX-License-Identifier: GPL-3.0-or-later
#include <memory>

#include "options/commands.hpp"
#include "stages/validate.hpp"

namespace bouncelab::cli {

Command validate_command() {
  auto options = std::make_shared<ValidateOptions>();
  return {
      "validate",
      "Any onset detector against sound whose times are exactly known: precision, recall, jitter, bound, errors",
      "Examples: bouncelab validate --config samples/validate.toml --detector builtin --detector 'aubioonset -i "
      "{wav}' --out out/validate\n"
      "          bouncelab validate --recordings folder --truth folder --detector 'python3 mine.py {wav}' --out "
      "out/mine\n"
      "          bouncelab validate --marks mine.txt --truth truth.csv\n"
      "Of each list in the configuration file the first value holds in all recordings but those of its other values.",
      validate_sections(*options),
      [options](Run& run) { return run_validate(*options, run); },
      {"simulate", "synthesize"},
      true};
}

}  // namespace bouncelab::cli
