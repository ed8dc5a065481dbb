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
BOUNCELAB_ASSET(paper, BOUNCELAB_PAPER)
BOUNCELAB_ASSET(sweep, BOUNCELAB_SWEEP)
BOUNCELAB_ASSET(script, BOUNCELAB_SCRIPT)
BOUNCELAB_ASSET(plotly, BOUNCELAB_PLOTLY)
