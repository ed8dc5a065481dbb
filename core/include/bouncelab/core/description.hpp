// SPDX-License-Identifier: GPL-3.0-or-later
/// What the members of a struct of options or results are, said once: name, text, kind, range, and how to reach them.
/// Command line, configuration files, completion by shells, the keywords of Python, JSON and the tables of
/// docs/formats.md are made of it by ordinary functions. A struct S is described by a function beside it,
///
///   const Description& members_of(const S*);
///
/// and what is described may hold described structs, lists of them and optional ones.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace bouncelab {

struct Value;
using Values = std::vector<Value>;
/// Values with their names, in the order in which they are written.
using Object = std::vector<std::pair<std::string, Value>>;

/// What a member holds. std::monostate: not known.
struct Value : std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, std::vector<double>,
                            std::vector<std::int64_t>, std::vector<std::string>, Values, Object> {
  using variant::variant;
};

/// One member of a struct.
struct Member {
  enum class Kind { flag, integer, natural, real, text, reals, integers, texts, values, object };

  std::string name;  ///< an option has '-' for '_'; see option_name
  std::string text;  ///< what it is: a sentence without its full stop
  Kind kind = Kind::text;
  bool may_be_unknown = false;

  std::function<Value(const void*)> get;
  std::function<void(void*, const Value&)> set;

  double least = -std::numeric_limits<double>::infinity();  ///< of a number, or of each of a list
  double greatest = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices;               ///< texts that it may be; empty: any
  std::function<void(const std::string&)> check;  ///< throws InvalidArgument where a text is none
  std::string form;                               ///< what a text or list looks like: FILE, X,Y
  std::size_t n_least = 0, n_most = 0;            ///< numbers in a list written with commas; 0: any
  bool is_required = false, is_positional = false;
  std::string unknown_text;  ///< what stands for "not known" where it may be: -1, 0
  bool is_left_out = false;  ///< where it is not known: a result without the name instead of null

  Member&& within(double lo, double hi) &&;
  Member&& one_of(std::vector<std::string> names) &&;
  Member&& looks_like(std::string how) &&;
  /// A list of `least` to `most` numbers with commas between them; others may be given several times.
  Member&& with_commas(std::string how, std::size_t least, std::size_t most) &&;
  Member&& checked_by(std::function<void(const std::string&)> accepts) &&;
  Member&& unknown_as(std::string what) &&;
  Member&& required() &&;
  Member&& positional() &&;
  Member&& left_out_where_unknown() &&;
};

/// All members of a struct, in the order in which they are shown.
using Description = std::vector<Member>;

/// What the members of an object hold: one that is not known and left out has no place, and what a member without a
/// name holds, an object, stands in this one.
Object object_of(const Description& description, const void* object);

/// The values of `more` behind those of `all`.
void append(Object& all, Object more);

// What follows makes members of pointers to them.

namespace describe_detail {

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};
template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
/// A list of values with names: a map, or pairs in an order of their own.
template <class T>
concept Named = requires(const T& all) {
  { all.begin()->first } -> std::convertible_to<std::string>;
  all.begin()->second;
};
template <class T>
concept Described = std::is_class_v<T> && requires(const T* s) {
  { members_of(s) } -> std::same_as<const Description&>;
};
/// One number, list or text where a struct stands for one: an interval is [lo, hi].
template <class T>
concept WrittenAs = std::is_class_v<T> && requires(const T& x) {
  { as_value(x) } -> std::same_as<Value>;
};

template <class T>
constexpr Member::Kind kind_of() {
  using Kind = Member::Kind;
  if constexpr (IsOptional<T>::value) {
    return kind_of<typename T::value_type>();
  } else if constexpr (Described<T> || Named<T> || std::is_same_v<T, Object>) {
    return Kind::object;
  } else if constexpr (WrittenAs<T>) {
    return Kind::values;
  } else if constexpr (std::is_same_v<T, bool>) {
    return Kind::flag;
  } else if constexpr (std::is_same_v<T, std::uint64_t>) {
    return Kind::natural;
  } else if constexpr (std::is_integral_v<T>) {
    return Kind::integer;
  } else if constexpr (std::is_floating_point_v<T>) {
    return Kind::real;
  } else if constexpr (IsVector<T>::value) {
    using Element = typename T::value_type;
    if constexpr (std::is_integral_v<Element>)
      return Kind::integers;
    else if constexpr (std::is_floating_point_v<Element>)
      return Kind::reals;
    else if constexpr (std::is_convertible_v<Element, std::string>)
      return Kind::texts;
    else
      return Kind::values;
  } else {
    return Kind::text;
  }
}

}  // namespace describe_detail

/// Anything that a member may be, as its value: an enumeration as the word that to_string has for it.
template <class T>
Value value_of(const T& x) {
  using namespace describe_detail;
  constexpr Member::Kind kind = kind_of<T>();
  if constexpr (WrittenAs<T>) {
    return as_value(x);
  } else if constexpr (IsOptional<T>::value) {
    return x ? value_of(*x) : Value{};
  } else if constexpr (Described<T>) {
    return object_of(members_of(static_cast<const T*>(nullptr)), &x);
  } else if constexpr (std::is_enum_v<T>) {
    return std::string(to_string(x));
  } else if constexpr (kind == Member::Kind::object) {
    Object all;
    for (const auto& [name, value] : x) all.emplace_back(name, value_of(value));
    return all;
  } else if constexpr (kind == Member::Kind::integer) {
    return static_cast<std::int64_t>(x);
  } else if constexpr (kind == Member::Kind::real) {
    return static_cast<double>(x);
  } else if constexpr (kind == Member::Kind::integers) {
    return std::vector<std::int64_t>(x.begin(), x.end());
  } else if constexpr (kind == Member::Kind::reals) {
    return std::vector<double>(x.begin(), x.end());
  } else if constexpr (kind == Member::Kind::texts) {
    return std::vector<std::string>(x.begin(), x.end());
  } else if constexpr (kind == Member::Kind::values) {
    Values all;
    all.reserve(x.size());
    for (const auto& element : x) all.push_back(value_of(element));
    return all;
  } else if constexpr (kind == Member::Kind::text && !std::is_same_v<T, Value>) {
    return std::string(x);
  } else {
    return x;
  }
}

namespace describe_detail {

template <class T>
void set_value(T& x, const Value& value) {
  constexpr Member::Kind kind = kind_of<T>();
  if constexpr (IsOptional<T>::value) {
    if (std::holds_alternative<std::monostate>(value))
      x.reset();
    else
      set_value(x.emplace(), value);
  } else if constexpr (kind == Member::Kind::integer) {
    x = static_cast<T>(std::get<std::int64_t>(value));
  } else if constexpr (kind == Member::Kind::real) {
    x = static_cast<T>(std::get<double>(value));
  } else if constexpr (kind == Member::Kind::integers) {
    const auto& all = std::get<std::vector<std::int64_t>>(value);
    x.assign(all.begin(), all.end());
  } else if constexpr (kind == Member::Kind::reals) {
    const auto& all = std::get<std::vector<double>>(value);
    x.assign(all.begin(), all.end());
  } else {
    x = std::get<T>(value);
  }
}

}  // namespace describe_detail

/// A member of S or of what S is made of.
/// @param reach  from S to the member: member<FitConfig>("nodes", [](auto& c) -> auto& { return c.law.nodes; }, "...")
template <class S, class Reach>
Member member(std::string name, Reach reach, std::string text) {
  using T = std::remove_cvref_t<decltype(reach(std::declval<S&>()))>;
  Member made;
  made.name = std::move(name);
  made.text = std::move(text);
  made.kind = describe_detail::kind_of<T>();
  made.may_be_unknown = describe_detail::IsOptional<T>::value;
  made.get = [reach](const void* s) { return value_of(reach(*static_cast<const S*>(s))); };
  made.set = [reach](void* s, const Value& value) { describe_detail::set_value(reach(*static_cast<S*>(s)), value); };
  return made;
}

template <class S, class T>
Member member(std::string name, T S::*where, std::string text) {
  return member<S>(
      std::move(name), [where](auto& s) -> auto& { return s.*where; }, std::move(text));
}

/// Described structs as a table: a list by the name of each member.
template <class T>
Object as_lists(const std::vector<T>& rows) {
  Object lists;
  for (const Member& member : members_of(static_cast<const T*>(nullptr))) {
    Values list;
    for (const T& row : rows) list.push_back(member.get(&row));
    lists.emplace_back(member.name, std::move(list));
  }
  return lists;
}

/// From a struct to a member of what it is made of: path(&MemoryFit::leak, &MemoryTest::z).
template <class S, class Reach>
struct Path {
  Reach reach;
  decltype(auto) operator()(const S& s) const { return reach(s); }
};
template <class S, class T, class... Further>
auto path(T S::*first, Further... further) {
  const auto reach = [=](const S& s) -> const auto& {
    if constexpr (sizeof...(further) == 0)
      return s.*first;
    else
      return path(further...)(s.*first);
  };
  return Path<S, decltype(reach)>{reach};
}

/// A member of a struct of results, which is written and not read: whatever `value_of` takes.
/// @param reach  pointer to the member, or a function of S: result<LawFit>("n_outliers", [](const LawFit& f) {...}, "")
template <class S, class Reach>
Member result(std::string name, Reach reach, std::string text) {
  using T = std::remove_cvref_t<decltype(std::invoke(reach, std::declval<const S&>()))>;
  Member made;
  made.name = std::move(name);
  made.text = std::move(text);
  made.kind = describe_detail::kind_of<T>();
  made.may_be_unknown = describe_detail::IsOptional<T>::value;
  made.get = [reach](const void* s) { return value_of(std::invoke(reach, *static_cast<const S*>(s))); };
  return made;
}
template <class S, class T>
Member result(std::string name, T S::*where, std::string text) {
  return result<S, T S::*>(std::move(name), where, std::move(text));
}

template <class S, class Reach>
Member result(std::string name, Path<S, Reach> where, std::string text) {
  return result<S, Path<S, Reach>>(std::move(name), where, std::move(text));
}

/// An enumeration, whose values have names: choice<S, E>("kind", &S::kind, {{"round", E::round}}, "...").
/// @param reach  pointer to the member, or as of `member`
template <class S, class E, class Reach>
Member choice(std::string name, Reach reach, std::vector<std::pair<std::string, E>> names, std::string text) {
  Member made;
  made.name = std::move(name);
  made.text = std::move(text);
  for (const auto& [word, meaning] : names) made.choices.push_back(word);
  made.get = [reach, names](const void* s) -> Value {
    for (const auto& [word, meaning] : names)
      if (meaning == std::invoke(reach, *static_cast<const S*>(s))) return word;
    return {};
  };
  made.set = [reach, names](void* s, const Value& value) {
    for (const auto& [word, meaning] : names)
      if (word == std::get<std::string>(value)) std::invoke(reach, *static_cast<S*>(s)) = meaning;
  };
  return made;
}

/// The value that a text means, as it is typed or stands in a file of options.
/// @throws InvalidArgument "'x' must be a decimal integer from 0 to 7", without the member's name
Value value_from_text(const Member& member, const std::string& text);
/// Several texts for one member that may be given several times; the last of others.
Value value_from_texts(const Member& member, const std::vector<std::string>& texts);
/// A value as it would be typed; empty where it is not known. Numbers with the fewest digits that read back the same.
std::string text_of(const Value& value);
/// What the object holds, as it would be typed.
std::string default_text(const Member& member, const void* object);
/// "0 to 1024"; empty where there is no range.
std::string range_of(const Member& member);
/// Whether each value is given by itself: --nodes 0.3 --nodes 0.6 (or --nodes 0.3 0.6).
bool is_repeated(const Member& member);
/// The name as an option has it: '-' for '_'.
std::string option_name(const Member& member);

/// JSON, valid whatever the texts in it are: of what is not UTF-8 each byte becomes U+FFFD. Numbers have the fewest
/// digits that read back the same; what is not known or not finite is null.
/// @param indent  spaces for each level; -1: all on one line
std::string json_text(const Value& value, int indent = -1);

}  // namespace bouncelab
