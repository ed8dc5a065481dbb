// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface/radius_law.hpp"

#include <charconv>
#include <cmath>
#include <sstream>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::sim {
namespace {

double draw(const ConstantRadii& law, Random&) { return law.radius; }
double draw(const UniformRadii& law, Random& random) { return random.uniform(law.lo, law.hi); }
double draw(const NormalRadii& law, Random& random) {
  double radius = 0.0;
  do radius = law.mean + law.sd * random.normal();
  while (radius <= 0.0);
  return radius;
}
double draw(const LognormalRadii& law, Random& random) { return law.median * exp(law.sigma * random.normal()); }
double draw(const ExponentialRadii& law, Random& random) { return law.mean * random.exponential(); }

bool is_good(const ConstantRadii& law) { return law.radius > 0.0 && law.radius < 1.0; }
bool is_good(const UniformRadii& law) { return law.lo > 0.0 && law.lo < law.hi && law.hi < 1.0; }
bool is_good(const NormalRadii& law) { return law.mean > 0.0 && law.mean < 1.0 && law.sd > 0.0 && law.sd < 1.0; }
bool is_good(const LognormalRadii& law) {
  return law.median > 0.0 && law.median < 1.0 && law.sigma > 0.0 && law.sigma < 10.0;
}
bool is_good(const ExponentialRadii& law) { return law.mean > 0.0 && law.mean < 1.0; }

/// Name and the two parameters by address: one description for reading and writing.
struct Description {
  const char* name;
  std::vector<double*> parameters;
};
Description describe(ConstantRadii& law) { return {"constant", {&law.radius}}; }
Description describe(UniformRadii& law) { return {"uniform", {&law.lo, &law.hi}}; }
Description describe(NormalRadii& law) { return {"normal", {&law.mean, &law.sd}}; }
Description describe(LognormalRadii& law) { return {"lognormal", {&law.median, &law.sigma}}; }
Description describe(ExponentialRadii& law) { return {"exponential", {&law.mean}}; }

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const auto comma = text.find(',');
    parts.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    text.remove_prefix(comma + 1);
  }
}

[[noreturn]] void refuse(std::string_view text) {
  throw InvalidArgument("radius law '" + std::string(text) +
                        "': may be constant:R, uniform:LO,HI, normal:MEAN,SD, lognormal:MEDIAN,SIGMA or "
                        "exponential:MEAN, radii in units of the ball's radius, between 0 and 1");
}

void read_parameters(const Description& law, std::string_view parameters, std::string_view text) {
  const auto parts = split(parameters);
  if (parts.size() != law.parameters.size()) refuse(text);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const char* end = parts[k].data() + parts[k].size();
    const auto read = std::from_chars(parts[k].data(), end, *law.parameters[k]);
    if (read.ec != std::errc{} || read.ptr != end) refuse(text);
  }
}

}  // namespace

double draw_radius(const RadiusLaw& law, Random& random) {
  return std::visit([&](const auto& l) { return draw(l, random); }, law);
}

void validate(const RadiusLaw& law) {
  if (!std::visit([](const auto& l) { return is_good(l); }, law)) refuse(to_text(law));
}

RadiusLaw radius_law_from_text(std::string_view text) {
  const auto colon = text.find(':');
  const std::string_view name = text.substr(0, colon);
  for (RadiusLaw law : {RadiusLaw{ConstantRadii{}}, RadiusLaw{UniformRadii{}}, RadiusLaw{NormalRadii{}},
                        RadiusLaw{LognormalRadii{}}, RadiusLaw{ExponentialRadii{}}}) {
    const Description description = std::visit([](auto& l) { return describe(l); }, law);
    if (name != description.name) continue;
    if (colon != std::string_view::npos) read_parameters(description, text.substr(colon + 1), text);
    if (!std::visit([](const auto& l) { return is_good(l); }, law)) refuse(text);
    return law;
  }
  refuse(text);
}

std::string to_text(const RadiusLaw& law) {
  RadiusLaw copy = law;
  const Description description = std::visit([](auto& l) { return describe(l); }, copy);
  std::string text = description.name;
  char buffer[32];
  for (std::size_t k = 0; k < description.parameters.size(); ++k) {
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, *description.parameters[k]).ptr;
    text += (k == 0 ? ':' : ',') + std::string(buffer, end);
  }
  return text;
}

}  // namespace bouncelab::sim
