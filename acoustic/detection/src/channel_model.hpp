// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "model_number.hpp"

namespace bouncelab::detection {

/// The numbers of the choice between channels and bands (docs/detector.md, "Bands and channels").
struct ChannelModel {
  double same_ball = 0.25;  ///< share of their log odds by which channels with the same impacts differ
  // Lower bands are not searched where they have nothing to add: where the impacts are nearly all that rises (of balls
  // of steel, glass and stone 0.99, of soft ones 0.2 to 0.99), and none is so faint that others may be missing.
  double explained = 0.97;
  double clear_rise = 8.0;  ///< beyond the threshold of candidates
  double edge_s = 3e-3;     ///< from sound that a file has lost: reach of the windows in which a rise is looked for
  double codec_noise_s = 30e-3;  ///< before an impact: a block of MP3 or AAC
  double same_echo_s = 5e-3;     ///< by which the delays of a row of echoes differ at most
};

BOUNCELAB_MODEL ChannelModel kChannels;

}  // namespace bouncelab::detection
