// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/impact_file.hpp"

#include <cstdint>
#include <memory>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/input_file.hpp"
#include "files/table_file.hpp"

namespace bouncelab::cli {
namespace {

/// Whole drops from a file: rows are read in pieces that begin with a drop.
class FileDrops {
 public:
  explicit FileDrops(const std::filesystem::path& path)
      : name_(input_name(path)), reader_(open_table(path, impact_columns())) {}

  bool next(Impacts& drop) {
    while (!at_end_ && (first_ == rows_.rows.size() || rows_.rows[first_].drop == rows_.rows.back().drop)) read_more();
    if (first_ == rows_.rows.size()) return false;
    std::size_t last = first_;
    while (last < rows_.rows.size() && rows_.rows[last].drop == rows_.rows[first_].drop) ++last;
    drop = stretch(first_, last);
    first_ = last;
    return true;
  }

 private:
  Impacts stretch(std::size_t first, std::size_t last) const {
    const auto part = [&](const auto& values) {
      return std::decay_t<decltype(values)>(values.begin() + static_cast<std::ptrdiff_t>(first),
                                            values.begin() + static_cast<std::ptrdiff_t>(last));
    };
    return {part(rows_.rows), rows_.states.empty() ? std::vector<ImpactState>{} : part(rows_.states)};
  }
  /// Appends a piece to what is left of the one before.
  void read_more() {
    const Table table = reader_->next(kPiece_rows);
    at_end_ = table.n_rows() < kPiece_rows;
    if (table.n_rows() == 0) return;
    const Impact* before = rows_.rows.empty() ? nullptr : &rows_.rows.back();
    const Impacts more = impacts_from_table(table, name_, before);
    if (before && more.states.empty() != rows_.states.empty())
      throw FileError(name_, table.place_of(0) + ": positions, velocities and spins must be in all rows or in none");
    if (first_ > 0) rows_ = stretch(first_, rows_.rows.size());
    first_ = 0;
    rows_.rows.insert(rows_.rows.end(), more.rows.begin(), more.rows.end());
    rows_.states.insert(rows_.states.end(), more.states.begin(), more.states.end());
  }

  std::string name_;
  std::unique_ptr<TableReader> reader_;
  Impacts rows_;
  std::size_t first_ = 0;
  bool at_end_ = false;
};

}  // namespace

synthesis::DropSource impact_file(const std::filesystem::path& path) {
  return [path, drops = std::shared_ptr<FileDrops>()](std::int64_t k, Impacts& drop) mutable {
    if (k == 0) drops = std::make_shared<FileDrops>(path);
    return drops->next(drop);
  };
}

}  // namespace bouncelab::cli
