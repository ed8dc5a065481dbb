// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/fit/between_recordings.hpp"

#include <chrono>
#include <cmath>
#include <cstddef>
#include "bouncelab/core/text.hpp"

namespace bouncelab::fit {
namespace {

constexpr double kSecondsOfDay = 86400.0;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A text from left to right; what does not fit leaves the place where it is.
class Reader {
 public:
  Reader(std::string_view text, std::size_t at) : text_(text), at_(at) {}

  std::size_t at() const { return at_; }
  bool at_end() const { return at_ == text_.size(); }
  bool at_digit() const { return !at_end() && is_digit(text_[at_]); }
  std::optional<int> number(std::size_t n_digits) {
    if (at_ + n_digits > text_.size()) return std::nullopt;
    int value = 0;
    for (std::size_t k = at_; k < at_ + n_digits; ++k) {
      if (!is_digit(text_[k])) return std::nullopt;
      value = 10 * value + (text_[k] - '0');
    }
    at_ += n_digits;
    return value;
  }
  /// One of these characters. @return it, or 0
  char one_of(std::string_view characters) {
    if (at_end() || characters.find(text_[at_]) == std::string_view::npos) return '\0';
    return text_[at_++];
  }
  double fraction() {
    double value = 0.0, unit = 0.1;
    for (; at_digit(); unit *= 0.1) value += unit * (text_[at_++] - '0');
    return value;
  }

 private:
  std::string_view text_;
  std::size_t at_;
};

std::optional<std::int64_t> calendar_day(Reader& text, std::string_view separators) {
  constexpr int kFirstYear = 1990, kLastYear = 2100;
  const auto year = text.number(4);
  const char separator = year ? text.one_of(separators) : '\0';
  const auto month = year ? text.number(2) : year;
  if (!month || (separator != '\0' && text.one_of(std::string_view(&separator, 1)) == '\0')) return std::nullopt;
  const auto day = text.number(2);
  if (!day || *year < kFirstYear || *year > kLastYear) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count();
}

/// Seconds since midnight.
std::optional<double> time_of_day_s(Reader& text, std::string_view separators) {
  const auto hour = text.number(2);
  const char separator = hour ? text.one_of(separators) : '\0';
  const auto minute = hour ? text.number(2) : hour;
  if (!minute || *hour > 23 || *minute > 59) return std::nullopt;
  double second = 0.0;
  Reader rest = text;
  if (separator == '\0' || rest.one_of(separators) != '\0')
    if (const auto s = rest.number(2); s && *s < 61) {
      second = *s;
      text = rest;
    }
  return 3600.0 * *hour + 60.0 * *minute + second;
}

RecordingDate date_at(std::int64_t day, std::optional<double> time_s) {
  return {static_cast<double>(day) + time_s.value_or(0.5 * kSecondsOfDay) / kSecondsOfDay, day};
}

}  // namespace

std::optional<RecordingDate> date_from_iso(std::string_view text) {
  Reader reader(text, 0);
  const auto day = calendar_day(reader, "-");
  if (!day) return std::nullopt;
  if (reader.at_end()) return date_at(*day, std::nullopt);
  if (reader.one_of("T ") == '\0') return std::nullopt;
  auto time_s = time_of_day_s(reader, ":");
  if (!time_s) return std::nullopt;
  if (reader.one_of(".,") != '\0') *time_s += reader.fraction();
  if (const char sign = reader.one_of("Z+-"); sign == '+' || sign == '-') {
    const auto hours = reader.number(2);
    reader.one_of(":");
    const auto minutes = reader.at_end() ? std::optional(0) : reader.number(2);
    if (!hours || !minutes) return std::nullopt;
    *time_s -= (sign == '+' ? 1.0 : -1.0) * (3600.0 * *hours + 60.0 * *minutes);
  }
  if (!reader.at_end()) return std::nullopt;
  return date_at(*day, time_s);
}

std::optional<RecordingDate> date_in_name(std::string_view name) {
  for (std::size_t at = name.size(); at-- > 0;) {
    if (!is_digit(name[at]) || (at > 0 && is_digit(name[at - 1]))) continue;
    Reader date(name, at);
    const auto day = calendar_day(date, "-_");
    if (!day) continue;
    Reader time = date;
    const bool stands_apart = time.one_of("T _-.") != '\0';
    const auto time_s = time_of_day_s(time, ":-._h");
    // 20261123999 is no date with a counter behind it but a number
    const bool is_time = time_s && !time.at_digit();
    if (!is_time && !stands_apart && date.at_digit()) continue;
    return date_at(*day, is_time ? time_s : std::nullopt);
  }
  return std::nullopt;
}

std::string day_in_words(std::int64_t calendar_day) {
  const std::chrono::year_month_day date{std::chrono::sys_days(std::chrono::days(calendar_day))};
  return formatted("%04d-%02u-%02u", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                   static_cast<unsigned>(date.day()));
}

std::string iso_in_words(const RecordingDate& date) {
  const auto seconds = static_cast<std::int64_t>(std::llround(date.day * kSecondsOfDay));
  constexpr std::int64_t kDay_s = 86400;
  const std::int64_t day = (seconds - (seconds % kDay_s + kDay_s) % kDay_s) / kDay_s;
  const auto rest = static_cast<int>(seconds - day * kDay_s);
  return day_in_words(day) + formatted("T%02d:%02d:%02d", rest / 3600, rest / 60 % 60, rest % 60);
}

}  // namespace bouncelab::fit
