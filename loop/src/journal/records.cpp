// SPDX-License-Identifier: GPL-3.0-or-later
// Finished parts of a run as lines of JSON, and back.
#include <nlohmann/json.hpp>

#include "bouncelab/core/error.hpp"
#include "bouncelab/loop/drops.hpp"
#include "bouncelab/loop/sweep.hpp"
#include "drops/recording_name.hpp"

namespace bouncelab::loop {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(double x) { return x; }
Json json_of(std::int64_t n) { return n; }
Json json_of(const Flags& flags) { return flags.text(); }
Json json_of(const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); }

void take(const Json& json, double& x) { x = json.get<double>(); }
void take(const Json& json, std::int64_t& n) { n = json.get<std::int64_t>(); }
void take(const Json& json, Flags& flags) { flags = Flags::from_text(json.get<std::string>()); }
void take(const Json& json, std::optional<double>& x) {
  if (!json.is_null()) x = json.get<double>();
}

// what of an impact is kept; `use` gets name and member
template <class Use>
void for_each_member(const Use& use, const Onset*) {
  use("t_s", &Onset::t_s);
  use("sigma_t_s", &Onset::sigma_t_s);
  use("amplitude", &Onset::amplitude);
  use("snr_db", &Onset::snr_db);
  use("probability", &Onset::probability);
  use("drop", &Onset::drop);
  use("impact", &Onset::impact);
  use("flags", &Onset::flags);
}

template <class Use>
void for_each_member(const Use& use, const synthesis::TrueImpact*) {
  use("t_s", &synthesis::TrueImpact::t_s);
  use("sigma_t_s", &synthesis::TrueImpact::sigma_t_s);
  use("amplitude", &synthesis::TrueImpact::amplitude);
  use("snr_db", &synthesis::TrueImpact::snr_db);
  use("drop", &synthesis::TrueImpact::drop);
  use("impact", &synthesis::TrueImpact::impact);
  use("flags", &synthesis::TrueImpact::flags);
  use("contact_time_s", &synthesis::TrueImpact::contact_time_s);
  use("travel_time_s", &synthesis::TrueImpact::travel_time_s);
  use("x_m", &synthesis::TrueImpact::x_m);
  use("y_m", &synthesis::TrueImpact::y_m);
  use("v_mps", &synthesis::TrueImpact::v_mps);
}

template <class Row>
Json columns(const std::vector<Row>& rows) {
  Json json = Json::object();
  const auto add = [&](const char* name, auto member) {
    Json values = Json::array();
    for (const Row& row : rows) values.push_back(json_of(row.*member));
    json[name] = std::move(values);
  };
  for_each_member(add, static_cast<const Row*>(nullptr));
  return json;
}

template <class Row>
std::vector<Row> rows_from(const Json& json) {
  std::vector<Row> rows(json.at("t_s").size());
  const auto fill = [&](const char* name, auto member) {
    for (std::size_t k = 0; k < rows.size(); ++k) take(json.at(name).at(k), rows[k].*member);
  };
  for_each_member(fill, static_cast<const Row*>(nullptr));
  return rows;
}

/// Reads a record; what is wrong with it becomes an InvalidArgument.
template <class Read>
auto parsed(std::string_view record, const Read& read) {
  try {
    return read(Json::parse(record));
  } catch (const Json::exception& error) {
    throw InvalidArgument(std::string("a record of the journal is not of the form expected: ") + error.what());
  }
}

}  // namespace

std::string to_record(const std::string& ball, const DropResult& drop) {
  return Json{{"ball", ball},
              {"drop", drop.drop},
              {"sound_s", drop.sound_s},
              {"synthesize_s", drop.synthesize_s},
              {"detect_s", drop.detect_s},
              {"truth", columns(drop.truth)},
              {"onsets", columns(drop.onsets)}}
      .dump();
}

NamedDrop drop_from_record(std::string_view record) {
  return parsed(record, [](const Json& json) {
    NamedDrop named{json.at("ball").get<std::string>(), {}};
    DropResult& drop = named.drop;
    drop.drop = json.at("drop").get<std::int64_t>();
    drop.sound_s = json.at("sound_s").get<double>();
    drop.synthesize_s = json.at("synthesize_s").get<double>();
    drop.detect_s = json.at("detect_s").get<double>();
    drop.truth = rows_from<synthesis::TrueImpact>(json.at("truth"));
    drop.onsets = rows_from<Onset>(json.at("onsets"));
    for (Onset& onset : drop.onsets) onset.recording = recording_name(named.ball, drop.drop);
    return named;
  });
}

std::string to_record(std::size_t index, const SweepPoint& point) {
  Json settings = Json::array(), values = Json::array();
  for (const auto& [option, value] : point.settings) settings.push_back({option, value});
  for (const SweepValue& v : point.values) values.push_back({v.name, json_of(v.value), v.is_count});
  return Json{{"point", index}, {"settings", settings}, {"values", values}, {"failure", point.failure}}.dump();
}

NumberedPoint point_from_record(std::string_view record) {
  return parsed(record, [](const Json& json) {
    NumberedPoint numbered{json.at("point").get<std::size_t>(), {}};
    for (const Json& s : json.at("settings"))
      numbered.point.settings.emplace_back(s.at(0).get<std::string>(), s.at(1).get<std::string>());
    for (const Json& v : json.at("values")) {
      SweepValue value{v.at(0).get<std::string>(), std::nullopt, v.at(2).get<bool>()};
      take(v.at(1), value.value);
      numbered.point.values.push_back(std::move(value));
    }
    numbered.point.failure = json.at("failure").get<std::string>();
    return numbered;
  });
}

}  // namespace bouncelab::loop
