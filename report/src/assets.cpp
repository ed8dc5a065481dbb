// SPDX-License-Identifier: GPL-3.0-or-later
#include "assets.hpp"

// The assembler puts the files into the program as they are: no generated source, no file to look for at run time.
#ifdef __EMSCRIPTEN__  // its assembler wants the kind of a section, and each object's type and size
#define BOUNCELAB_SECTION(name) ".section .rodata.bouncelab_asset_" #name ",\"\",@\n"
#define BOUNCELAB_SYMBOL(name, size) ".type " name ",@object\n.size " name ", " size "\n.globl " name "\n" name ":\n"
#define BOUNCELAB_END ".section .text,\"\",@\n"
#else
#define BOUNCELAB_SECTION(name) ".section .rodata\n"
#define BOUNCELAB_SYMBOL(name, size) ".global " name "\n" name ":\n"
#define BOUNCELAB_END ".previous\n"
#endif
#define BOUNCELAB_ASSET(name, path)                                                                                    \
  __asm__(BOUNCELAB_SECTION(name) BOUNCELAB_SYMBOL(                                                                    \
      "bouncelab_asset_" #name,                                                                                        \
      "bouncelab_asset_" #name "_end-bouncelab_asset_" #name) ".incbin \"" path                                        \
                                                              "\"\n" BOUNCELAB_SYMBOL("bouncelab_asset_" #name "_end", \
                                                                                      "1") ".byte 0\n" BOUNCELAB_END); \
  extern "C" const char bouncelab_asset_##name[];                                                                      \
  extern "C" const char bouncelab_asset_##name##_end[];                                                                \
  namespace bouncelab::report {                                                                                        \
  std::string_view asset_##name() {                                                                                    \
    return {bouncelab_asset_##name, static_cast<std::size_t>(bouncelab_asset_##name##_end - bouncelab_asset_##name)};  \
  }                                                                                                                    \
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
BOUNCELAB_ASSET(compare, BOUNCELAB_SCRIPTS "/compare.js")
BOUNCELAB_ASSET(validation, BOUNCELAB_SCRIPTS "/validation.js")
BOUNCELAB_ASSET(tables, BOUNCELAB_SCRIPTS "/tables.js")
BOUNCELAB_ASSET(ball, BOUNCELAB_SCRIPTS "/ball.js")
BOUNCELAB_ASSET(answer, BOUNCELAB_SCRIPTS "/answer.js")
BOUNCELAB_ASSET(page, BOUNCELAB_SCRIPTS "/page.js")
#ifdef __EMSCRIPTEN__  // a file of the page, which puts it into the report (tools/web/src/api.js)
std::string_view bouncelab::report::asset_plotly() { return "@PLOTLY@"; }
#else
BOUNCELAB_ASSET(plotly, BOUNCELAB_PLOTLY)
#endif

namespace bouncelab::report {

std::string asset_script() {
  std::string script;
  for (const std::string_view part :
       {asset_text(), asset_plot(), asset_law_figures(), asset_scatter_figures(), asset_sound_figures(),
        asset_diagnostics(), asset_memory(), asset_reservoir(), asset_paper(), asset_sweep(), asset_compare(),
        asset_validation(), asset_tables(), asset_ball(), asset_answer(), asset_page()})
    script += part;
  return script;
}

}  // namespace bouncelab::report
