// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/description.hpp"
#include "bouncelab/core/note.hpp"
#include "bouncelab/core/samples.hpp"
#include "bouncelab/fit/estimate.hpp"
#include "bouncelab/fit/law_fit.hpp"

namespace bouncelab::fit {

/// What differs within a group, by which differences between groups are judged.
enum class GroupUnit { drops, recordings };
/// "drops", "recordings"
const char* to_string(GroupUnit unit);

/// The law of one group (the recordings of a plate, or one recording) at speeds common to all groups. Its errors are
/// those of independent samples.
struct GroupLaw {
  std::string name;
  std::size_t n = 0;  ///< samples fitted
  std::size_t n_units = 0;
  std::vector<NodeEstimate> nodes;
  std::vector<NamedEstimate> parameters;
};
Description members_of(const GroupLaw*);

/// A group less the reference. Errors and intervals include what differs within the groups.
struct GroupDifference {
  std::string reference, group;
  Estimate offset;                ///< of eps, as a constant at all speeds
  double detectable = 0.0;        ///< an offset that such data show in four of five experiments
  std::optional<double> p_value;  ///< of so large an offset by chance, times the number of pairs; absent: ndf = 0
  std::vector<NodeEstimate> nodes;
  std::vector<NamedEstimate> parameters;
};
Description members_of(const GroupDifference*);

struct GroupDifferences {
  std::optional<Note> why;  ///< why there are no rows; absent where there are
  GroupUnit unit = GroupUnit::drops;
  double ndf = 0.0;                 ///< units less groups; 0: how units of a group differ is not known
  std::optional<double> deviation;  ///< of eps between units of a group, standard deviation; 0: none seen
  std::vector<GroupLaw> groups;
  std::vector<GroupDifference> rows;  ///< every pair
};
Description members_of(const GroupDifferences*);

inline constexpr std::size_t kMostGroups = 4;

/// Do groups differ by more than the drops (or recordings) within them do? A nested analysis of variance about the law
/// of each group: unit u has the mean residual r_u, weighted by the inverse variance of the scatter, with variance
/// tau^2 + 1/W_u, W_u the sum of the weights, tau by moments (DerSimonian & Laird, doi:10.1016/0197-2456(86)90046-2);
///
///   w_u = 1 / (tau^2 + 1/W_u),   q = sum w_u (r_u - mean of its group)^2 / (units - groups),
///   variance of a group's mean = q / sum w_u,
///
/// and the offset of two groups over the root of both variances is Student's t with units - groups degrees of freedom
/// (Knapp & Hartung, Stat. Med. 22, 2693 (2003), doi:10.1002/sim.1482). The variance is never taken below that of
/// independent samples. What differs within the groups enters the errors of nodes and constants as a constant offset of
/// eps. The offset is of the means, nodes and constants are those of the laws, of the peak.
///
/// The unit is the recording where some group has several, else the drop. With one unit in each group errors are those
/// of independent samples and there is no p.
/// @param groups  2 to kMostGroups, each a name and its usable samples (no flag, finite, v > 0)
GroupDifferences compare_groups(const std::vector<std::pair<std::string, RestitutionSamples>>& groups);

}  // namespace bouncelab::fit
