// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/core/description.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab {
namespace {

using Kind = Member::Kind;

/// Absent where the text is not one decimal number that T holds, with or without a sign.
template <class T>
std::optional<T> decimal(std::string_view text) {
  T value{};
  if (parse_number(text, value) != std::errc{}) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>)
    if (!std::isfinite(value)) return std::nullopt;
  return value;
}

template <class T>
std::string text_of_number(T number) {
  if constexpr (std::is_floating_point_v<T>)  // 1000000, not 1e+06
    return number == std::trunc(number) && std::abs(number) < 1e10 ? std::to_string(static_cast<std::int64_t>(number))
                                                                   : number_text(number);
  else
    return std::to_string(number);
}

[[noreturn]] void refuse(const std::string& text, const std::string& what) {
  throw InvalidArgument("'" + printable(text) + "' must be " + what);
}

bool has_range(const Member& member) { return std::isfinite(member.least) || std::isfinite(member.greatest); }

std::string from_range(const Member& member) { return has_range(member) ? " from " + range_of(member) : ""; }

/// The unit that stands at the end of the help, "... [Pa]": a number of another one, 10MPa, is then seen to be none.
std::string in_unit(const Member& member) {
  const std::size_t bracket = member.text.rfind('[');
  if (!member.text.ends_with(']') || bracket == std::string_view::npos) return {};
  return ", in " + std::string(member.text.substr(bracket + 1, member.text.size() - bracket - 2));
}

template <class T>
T number(const Member& member, const std::string& text) {
  const std::optional<T> value = decimal<T>(text);
  const bool is_in_range =
      value && static_cast<double>(*value) >= member.least && static_cast<double>(*value) <= member.greatest;
  if (is_in_range) return *value;
  if constexpr (std::is_floating_point_v<T>)
    refuse(text, "a finite decimal number" + from_range(member) + in_unit(member));
  else
    refuse(text,
           "a decimal integer" + (has_range(member) ? from_range(member)
                                                    : " from " + text_of_number(std::numeric_limits<T>::min()) +
                                                          " to " + text_of_number(std::numeric_limits<T>::max())));
}

std::vector<std::string> between_commas(std::string_view text) {
  std::vector<std::string> parts{""};
  for (const char c : text) {
    if (c == ',')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

std::vector<double> list_with_commas(const Member& member, const std::string& text) {
  const std::vector<std::string> parts = between_commas(text);
  std::vector<double> values;
  for (const std::string& part : parts)
    if (const auto value = decimal<double>(part)) values.push_back(*value);
  if (values.size() != parts.size() || values.size() < member.n_least || values.size() > member.n_most)
    refuse(text, text_of_number(member.n_least) +
                     (member.n_least == member.n_most ? "" : " or " + text_of_number(member.n_most)) +
                     " finite decimal numbers, " + std::string(member.form));
  for (const double value : values)
    if (!(value >= member.least && value <= member.greatest)) refuse(text, "numbers from " + range_of(member));
  return values;
}

/// Of a list of any length, which may also be given one by one.
template <class T>
std::vector<T> numbers(const Member& member, const std::string& text) {
  std::vector<T> values;
  for (const std::string& part : between_commas(text)) values.push_back(number<T>(member, part));
  return values;
}

std::string checked(const Member& member, const std::string& text) {
  if (member.check) member.check(text);
  const std::vector<std::string> choices = choices_of(member);
  if (choices.empty() || std::find(choices.begin(), choices.end(), text) != choices.end()) return text;
  std::string all;
  for (const std::string& choice : choices) all += (all.empty() ? "" : ", ") + choice;
  refuse(text, "one of " + all);
}

}  // namespace

void append(Object& all, Object more) {
  for (auto& named : more) all.push_back(std::move(named));
}

Object object_of(Description description, const void* object) {
  Object all;
  for (const Member& member : description) {
    Value value = member.get(object);
    if (member.name.empty())
      append(all, std::get<Object>(value));
    else if (!member.is_left_out || !std::holds_alternative<std::monostate>(value))
      all.emplace_back(member.name, std::move(value));
  }
  return all;
}

Value value_from_text(const Member& member, const std::string& text) {
  if (member.may_be_unknown && text == member.unknown_text) return {};
  switch (member.kind) {
    case Kind::flag:
      if (text != "true" && text != "false") refuse(text, "true or false");
      return text == "true";
    case Kind::integer:
      return number<std::int64_t>(member, text);
    case Kind::natural:
      return number<std::uint64_t>(member, text);
    case Kind::real:
      return number<double>(member, text);
    case Kind::text:
      return checked(member, text);
    case Kind::texts:
      return std::vector<std::string>{checked(member, text)};
    case Kind::integers:
      return numbers<std::int64_t>(member, text);
    case Kind::reals:
      return member.n_most > 0 ? list_with_commas(member, text) : numbers<double>(member, text);
    case Kind::values:  // of results, which nobody types
    case Kind::object:
      break;
  }
  assert(false);
  return {};
}

Value value_from_texts(const Member& member, const std::vector<std::string>& texts) {
  if (!is_repeated(member)) return value_from_text(member, texts.back());
  Value all = value_from_text(member, texts.front());
  for (std::size_t k = 1; k < texts.size(); ++k)
    std::visit(
        [&](auto& list) {
          using T = std::remove_cvref_t<decltype(list)>;
          if constexpr (describe_detail::IsVector<T>::value && !std::is_same_v<T, Values> &&
                        !std::is_same_v<T, Object>) {
            const T more = std::get<T>(value_from_text(member, texts[k]));
            list.insert(list.end(), more.begin(), more.end());
          }
        },
        all);
  return all;
}

std::string text_of(const Value& value) {
  return std::visit(
      [](const auto& x) -> std::string {
        using T = std::remove_cvref_t<decltype(x)>;
        if constexpr (std::is_same_v<T, bool>) {
          return x ? "true" : "false";
        } else if constexpr (std::is_arithmetic_v<T>) {
          return text_of_number(x);
        } else if constexpr (std::is_same_v<T, std::string>) {
          return x;
        } else if constexpr (describe_detail::IsVector<T>::value && !std::is_same_v<T, Object>) {
          std::string all;
          for (const auto& element : x) {
            if (&element != &x.front()) all += ',';
            all += text_of(Value(element));
          }
          return all;
        } else {
          return "";
        }
      },
      value);
}

std::string default_text(const Member& member, const void* object) {
  const Value value = member.get(object);
  return std::holds_alternative<std::monostate>(value) ? std::string(member.unknown_text) : text_of(value);
}

std::string range_of(const Member& member) {
  if (!has_range(member)) return "";
  const auto limit = [&](double x) {
    return member.kind == Kind::integer || member.kind == Kind::integers ? text_of_number(static_cast<std::int64_t>(x))
                                                                         : text_of_number(x);
  };
  return limit(member.least) + " to " + limit(member.greatest);
}

bool is_repeated(const Member& member) {
  return member.kind == Kind::texts || member.kind == Kind::integers ||
         (member.kind == Kind::reals && member.n_most == 0);
}

std::vector<std::string> choices_of(const Member& member) {
  return member.choices.empty() ? std::vector<std::string>{} : between_commas(member.choices);
}

namespace {

/// As they would be typed one by one.
std::vector<std::string> texts_of(const Member& member, const Value& value) {
  if (!is_repeated(member)) return {text_of(value)};
  return std::visit(
      [](const auto& all) {
        std::vector<std::string> texts;
        if constexpr (describe_detail::IsVector<std::remove_cvref_t<decltype(all)>>::value)
          if constexpr (!std::is_same_v<std::remove_cvref_t<decltype(all)>, Object>)
            for (const auto& element : all) texts.push_back(text_of(Value(element)));
        return texts;
      },
      static_cast<const Value::variant&>(value));
}

}  // namespace

void check_options(Description description, const void* object) {
  for (const Member& member : description) {
    if (member.write == nullptr) continue;
    const Value value = member.get(object);
    if (std::holds_alternative<std::monostate>(value)) continue;
    try {
      for (const std::string& text : texts_of(member, value))
        if (std::holds_alternative<std::monostate>(value_from_text(member, text)))
          throw InvalidArgument("'" + text + "' stands for a value that is not known; leave it empty");
    } catch (const InvalidArgument& error) {
      throw InvalidArgument(std::string(member.name) + ": " + error.what());
    }
  }
}

std::string option_name(const Member& member) {
  std::string name(member.name);
  std::replace(name.begin(), name.end(), '_', '-');
  return name;
}

namespace {

using Json = nlohmann::ordered_json;

Json json_of(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json json_of(const Value& value) {
  return std::visit(
      [](const auto& x) -> Json {
        using T = std::remove_cvref_t<decltype(x)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          return nullptr;
        } else if constexpr (std::is_same_v<T, double>) {
          return json_of(x);
        } else if constexpr (std::is_same_v<T, std::vector<double>> || std::is_same_v<T, Values>) {
          Json all = Json::array();
          for (const auto& element : x) all.push_back(json_of(element));
          return all;
        } else if constexpr (std::is_same_v<T, Object>) {
          Json all = Json::object();
          for (const auto& [name, element] : x) all[name] = json_of(element);
          return all;
        } else {
          return x;
        }
      },
      value);
}

}  // namespace

std::string json_text(const Value& value, int indent) {
  return json_of(value).dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace bouncelab
