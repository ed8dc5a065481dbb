// SPDX-License-Identifier: GPL-3.0-or-later
#include "files/table_bytes.hpp"

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

namespace bouncelab::cli {
namespace {

void put_size(std::string& bytes, std::size_t size) {
  const std::uint64_t value = size;
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void put(std::string& bytes, const std::string& text) {
  put_size(bytes, text.size());
  bytes += text;
}

template <class T>
void put(std::string& bytes, const std::vector<T>& numbers) {
  put_size(bytes, numbers.size());
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
}

void put(std::string& bytes, const std::vector<std::string>& texts) {
  put_size(bytes, texts.size());
  for (const std::string& text : texts) put(bytes, text);
}

/// What was put, from the front on.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : left_(bytes) {}

  bool at_end() const { return left_.empty(); }
  std::size_t size() {
    std::uint64_t value = 0;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string text() { return std::string(take(size())); }
  template <class T>
  std::vector<T> numbers() {
    const std::size_t n = size();
    if (n > left_.size() / sizeof(T)) throw std::out_of_range("the table ends early");
    const std::string_view bytes = take(n * sizeof(T));
    std::vector<T> values(n);
    if (n > 0) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  std::vector<std::string> texts() {
    std::vector<std::string> values;
    for (std::size_t n = size(); n > 0; --n) values.push_back(text());
    return values;
  }

 private:
  std::string_view take(std::size_t n) {
    if (n > left_.size()) throw std::out_of_range("the table ends early");
    const std::string_view taken = left_.substr(0, n);
    left_.remove_prefix(n);
    return taken;
  }
  std::string_view left_;
};

}  // namespace

std::string to_bytes(const Table& table) {
  std::string bytes;
  for (const Column& column : table.columns) {
    put(bytes, column.name);
    put_size(bytes, column.values.index());
    std::visit([&](const auto& values) { put(bytes, values); }, column.values);
  }
  return bytes;
}

Table table_from_bytes(std::string_view bytes) {
  Table table;
  for (Bytes from(bytes); !from.at_end();) {
    Column column{from.text(), {}};
    const std::size_t type = from.size();
    if (type == 0)
      column.values = from.numbers<double>();
    else if (type == 1)
      column.values = from.numbers<std::int64_t>();
    else
      column.values = from.texts();
    table.columns.push_back(std::move(column));
  }
  return table;
}

}  // namespace bouncelab::cli
