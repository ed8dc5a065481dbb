// SPDX-License-Identifier: GPL-3.0-or-later
#include "assets.hpp"

// The assembler puts the files into the program as they are: no generated source, no file to look for at run time.
#define BOUNCELAB_ASSET(name, path)                                                                           \
  __asm__(".section .rodata\n.global bouncelab_asset_" #name "\nbouncelab_asset_" #name ":\n.incbin \"" path  \
          "\"\n.global bouncelab_asset_" #name "_end\nbouncelab_asset_" #name "_end:\n.byte 0\n.previous\n"); \
  extern "C" const char bouncelab_asset_##name[];                                                             \
  extern "C" const char bouncelab_asset_##name##_end[];                                                       \
  namespace bouncelab::report {                                                                               \
  std::string_view asset_##name() { return {bouncelab_asset_##name, bouncelab_asset_##name##_end}; }          \
  }

BOUNCELAB_ASSET(template, BOUNCELAB_TEMPLATE)
BOUNCELAB_ASSET(style, BOUNCELAB_STYLE)
BOUNCELAB_ASSET(text, BOUNCELAB_SCRIPTS "/text.js")
BOUNCELAB_ASSET(plot, BOUNCELAB_SCRIPTS "/plot.js")
BOUNCELAB_ASSET(law_figures, BOUNCELAB_SCRIPTS "/law_figures.js")
BOUNCELAB_ASSET(scatter_figures, BOUNCELAB_SCRIPTS "/scatter_figures.js")
BOUNCELAB_ASSET(sound_figures, BOUNCELAB_SCRIPTS "/sound_figures.js")
BOUNCELAB_ASSET(diagnostics, BOUNCELAB_SCRIPTS "/diagnostics.js")
BOUNCELAB_ASSET(memory, BOUNCELAB_SCRIPTS "/memory.js")
BOUNCELAB_ASSET(reservoir, BOUNCELAB_SCRIPTS "/reservoir.js")
BOUNCELAB_ASSET(paper, BOUNCELAB_SCRIPTS "/paper.js")
BOUNCELAB_ASSET(sweep, BOUNCELAB_SCRIPTS "/sweep.js")
BOUNCELAB_ASSET(tables, BOUNCELAB_SCRIPTS "/tables.js")
BOUNCELAB_ASSET(page, BOUNCELAB_SCRIPTS "/page.js")
BOUNCELAB_ASSET(plotly, BOUNCELAB_PLOTLY)

namespace bouncelab::report {

std::string asset_script() {
  std::string script;
  for (const std::string_view part : {asset_text(), asset_plot(), asset_law_figures(), asset_scatter_figures(),
                                      asset_sound_figures(), asset_diagnostics(), asset_memory(), asset_reservoir(),
                                      asset_paper(), asset_sweep(), asset_tables(), asset_page()})
    script += part;
  return script;
}

}  // namespace bouncelab::report
