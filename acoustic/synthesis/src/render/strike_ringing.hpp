// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "excitation/resonator_bank.hpp"

namespace bouncelab::synthesis {

/// The sound of contacts in one channel from a frame on, piece by piece: their waves until they ring freely, and from
/// there on the ringing of all in one state.
class StrikeRinging {
 public:
  /// @param first  a multiple of ResonatorBank::kBlock
  /// @param bank   must outlive this
  StrikeRinging(const ResonatorBank& bank, double silence, std::int64_t first)
      : bank_(bank), silence_(silence), at_(first), state_(bank.size()) {}

  /// Before the first piece, in the order of time.
  void add(ContactWave wave);
  /// Adds the sound of the next frames to `out`, whose length is a multiple of ResonatorBank::kBlock.
  template <class T>
  void add_next(std::span<T> out);

 private:
  template <class T>
  void ring(std::span<T> out);

  const ResonatorBank& bank_;
  double silence_;
  std::int64_t at_;  // frame of the next piece
  PoleValues state_;
  std::vector<ContactWave> waves_;  // that have not joined the ringing
};

}  // namespace bouncelab::synthesis
