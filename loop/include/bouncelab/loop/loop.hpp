// SPDX-License-Identifier: GPL-3.0-or-later
/// Start here: the closed loop, impact times -> sound -> impact times -> constants, in memory.
#pragma once

#include "bouncelab/loop/analyze.hpp"         // recordings -> impact times -> law
#include "bouncelab/loop/closed_loop.hpp"     // the whole chain in one call
#include "bouncelab/loop/comparison.hpp"      // many recordings: what they have in common, and which differ
#include "bouncelab/loop/detector_score.hpp"  // any onset detector against true times
#include "bouncelab/loop/loop_score.hpp"      // what went in beside what came out; the paper's conclusions
#include "bouncelab/loop/sweep.hpp"           // the chain for every combination of some settings
#include "bouncelab/loop/theory.hpp"  // scatter and reservoir of the simulation beside what theory and sound say
