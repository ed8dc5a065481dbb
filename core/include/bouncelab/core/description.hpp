// SPDX-License-Identifier: GPL-3.0-or-later
/// What the members of a struct of options or results are, said once: name, text, kind, range, and how to reach them.
/// Command line, configuration files, completion by shells, the keywords of Python, the parameters of Vamp and the
/// page, JSON and the tables of docs/formats.md are made of it by ordinary functions. A struct S is described by a
/// function beside it, which returns a table that is there before the program runs:
///
///   Description members_of(const S*) {
///     static constexpr Member all[]{member<&S::n>("n", "Number of drops").within(1, 1e9), ...};
///     return all;
///   }
///
/// and what is described may hold described structs, lists of them and optional ones.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
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

/// One member of a struct. Texts are not copied: they are literals, or live as long as the description.
struct Member {
  enum class Kind { flag, integer, natural, real, text, reals, integers, texts, values, object };

  std::string_view name;  ///< an option has '-' for '_'; see option_name
  std::string_view text;  ///< what it is: a sentence without its full stop
  Kind kind = Kind::text;
  bool may_be_unknown = false;
  bool is_required = false, is_positional = false;
  bool is_output = false;    ///< a file or a folder that is written
  bool is_left_out = false;  ///< where it is not known: a result without the name instead of null

  const void* (*place)(const void* object) = nullptr;        ///< address of the member
  Value (*read)(const void* place) = nullptr;                ///< what stands there
  void (*write)(void* place, const Value& value) = nullptr;  ///< nullptr: of results, which nobody types

  double least = -std::numeric_limits<double>::infinity();  ///< of a number, or of each of a list
  double greatest = std::numeric_limits<double>::infinity();
  std::string_view choices{};                   ///< texts that it may be, with commas between them; empty: any
  void (*check)(const std::string&) = nullptr;  ///< throws InvalidArgument where a text is none
  std::string_view form{};                      ///< what a text or list looks like: FILE, X,Y
  std::size_t n_least = 0, n_most = 0;          ///< numbers in a list written with commas; 0: any
  std::string_view unknown_text{};              ///< what stands for "not known" where it may be: -1, 0

  Value get(const void* object) const { return read(place(object)); }
  void set(void* object, const Value& value) const { write(const_cast<void*>(place(object)), value); }

  /// The same member but for one thing.
  template <class T>
  constexpr Member with(T Member::*what, std::type_identity_t<T> value) const {
    Member changed = *this;
    changed.*what = value;
    return changed;
  }

  constexpr Member within(double lo, double hi) const { return with(&Member::least, lo).with(&Member::greatest, hi); }
  /// @param words  with commas between them
  constexpr Member one_of(std::string_view words) const { return with(&Member::choices, words); }
  constexpr Member looks_like(std::string_view how) const { return with(&Member::form, how); }
  /// A list of `lo` to `hi` numbers with commas between them; others have any number, also one by one.
  constexpr Member with_commas(std::string_view how, std::size_t lo, std::size_t hi) const {
    return looks_like(how).with(&Member::n_least, lo).with(&Member::n_most, hi);
  }
  constexpr Member checked_by(void (*accepts)(const std::string&)) const { return with(&Member::check, accepts); }
  constexpr Member unknown_as(std::string_view what) const { return with(&Member::unknown_text, what); }
  constexpr Member required() const { return with(&Member::is_required, true); }
  constexpr Member positional() const { return with(&Member::is_positional, true); }
  constexpr Member writes(std::string_view how) const { return looks_like(how).with(&Member::is_output, true); }
  constexpr Member left_out_where_unknown() const { return with(&Member::is_left_out, true); }
  /// Of a member that is computed: how a text sets it.
  constexpr Member set_by(void (*sets)(void* object, const Value& text)) const { return with(&Member::write, sets); }
};

/// All members of a struct, in the order in which they are shown.
using Description = std::span<const Member>;

/// What the members of an object hold: one that is not known and left out has no place, and what a member without a
/// name holds, an object, stands in this one.
Object object_of(Description description, const void* object);

template <class T>
requires requires(const T* s) { members_of(s); }
Object object_of(const T& x) { return object_of(members_of(&x), &x); }

/// The values of `more` behind those of `all`.
void append(Object& all, Object more);

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
  { members_of(s) } -> std::same_as<Description>;
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
    return object_of(members_of(&x), &x);
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
Value read_as(const void* place) {
  return value_of(*static_cast<const T*>(place));
}

/// What a text can set: numbers, texts and lists of them. @throws std::bad_variant_access where the value is another
template <class T>
void write_as(void* place, const Value& value) {
  T& x = *static_cast<T*>(place);
  constexpr Member::Kind kind = kind_of<T>();
  if constexpr (IsOptional<T>::value) {
    x.reset();
    if (!std::holds_alternative<std::monostate>(value)) write_as<typename T::value_type>(&x.emplace(), value);
  } else if constexpr (kind == Member::Kind::integer) {
    x = static_cast<T>(std::get<std::int64_t>(value));
  } else if constexpr (kind == Member::Kind::integers) {
    const auto& all = std::get<std::vector<std::int64_t>>(value);
    x.assign(all.begin(), all.end());
  } else {
    x = std::get<T>(value);
  }
}
/// What options are.
template <class T>
concept Plain =
    std::same_as<T, bool> || std::same_as<T, int> || std::same_as<T, std::int64_t> || std::same_as<T, std::uint64_t> ||
    std::same_as<T, double> || std::same_as<T, std::string> || std::same_as<T, std::vector<int>> ||
    std::same_as<T, std::vector<double>> || std::same_as<T, std::vector<std::string>> ||
    std::same_as<T, std::optional<int>> || std::same_as<T, std::optional<double>>;

template <class T, class S>
S owner_of(T S::*);
template <class T, class S>
S owner_of(T (*)(const S&));
template <class T, class L, class S>
S argument_of(T (L::*)(const S&) const);

inline const void* itself(const void* object) { return object; }

template <auto First, auto... Further>
const auto& reach(const decltype(owner_of(First))& object) {
  if constexpr (sizeof...(Further) == 0)
    return object.*First;
  else
    return reach<Further...>(object.*First);
}

template <class T>
constexpr Member of_type(std::string_view name, std::string_view text) {
  Member made;
  made.name = name;
  made.text = text;
  made.kind = kind_of<T>();
  made.may_be_unknown = IsOptional<T>::value;
  return made;
}

}  // namespace describe_detail

/// A member by its address, or by those on the way to it: member<&FitConfig::law, &LawConfig::orders>("orders", "..."),
/// or what a function makes of the struct: member<mass_kg>("mass_kg", "...").
template <auto First, auto... Further>
constexpr Member member(std::string_view name, std::string_view text) {
  using namespace describe_detail;
  using S = decltype(owner_of(First));
  if constexpr (std::is_member_object_pointer_v<decltype(First)>) {
    using T = std::remove_cvref_t<decltype(reach<First, Further...>(std::declval<const S&>()))>;
    Member made = of_type<T>(name, text);
    made.place = [](const void* object) -> const void* {
      return &reach<First, Further...>(*static_cast<const S*>(object));
    };
    made.read = read_as<T>;
    if constexpr (Plain<T>) made.write = write_as<T>;
    return made;
  } else {
    using T = std::remove_cvref_t<std::invoke_result_t<decltype(First), const S&>>;
    Member made = of_type<T>(name, text);
    made.place = itself;
    made.read = [](const void* object) { return value_of(std::invoke(First, *static_cast<const S*>(object))); };
    return made;
  }
}

/// A member that is computed: computed("n_outliers", [](const LawFit& f) { return f.outliers.size(); }, "...").
template <class Function>
constexpr Member computed(std::string_view name, Function, std::string_view text) {
  using namespace describe_detail;
  using S = decltype(argument_of(&Function::operator()));
  using T = std::remove_cvref_t<decltype(Function{}(std::declval<const S&>()))>;
  Member made = of_type<T>(name, text);
  made.place = itself;
  made.read = [](const void* object) { return value_of(Function{}(*static_cast<const S*>(object))); };
  return made;
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
/// The texts that it may be; empty: any.
std::vector<std::string> choices_of(const Member& member);
/// Refuses what nobody could type: for structs of options that a program fills.
/// @throws InvalidArgument naming the first member that is out of its range: "gravity: 'nan' must be ..."
void check_options(Description description, const void* object);

template <class T>
requires requires(const T* s) { members_of(s); }
void check_options(const T& options) { check_options(members_of(&options), &options); }

/// Whether each value is given by itself: --nodes 0.3 --nodes 0.6 (or --nodes 0.3 0.6).
bool is_repeated(const Member& member);
/// The name as an option has it: '-' for '_'.
std::string option_name(const Member& member);

/// JSON, valid whatever the texts in it are: of what is not UTF-8 each byte becomes U+FFFD. Numbers have the fewest
/// digits that read back the same; what is not known or not finite is null.
/// @param indent  spaces for each level; -1: all on one line
std::string json_text(const Value& value, int indent = -1);

}  // namespace bouncelab
