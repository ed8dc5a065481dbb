// SPDX-License-Identifier: GPL-3.0-or-later
// What a host asks the library for: the plugins, one after the other.
#include <vamp-sdk/PluginAdapter.h>
#include <vamp/vamp.h>

#include "impacts_plugin.hpp"
#include "restitution_plugin.hpp"

extern "C" __attribute__((visibility("default"))) const VampPluginDescriptor* vampGetPluginDescriptor(
    unsigned int host_api_version, unsigned int index) {
  static Vamp::PluginAdapter<bouncelab::vamp::ImpactsPlugin> impacts;
  static Vamp::PluginAdapter<bouncelab::vamp::RestitutionPlugin> restitution;
  if (host_api_version < 1) return nullptr;
  switch (index) {
    case 0:
      return impacts.getDescriptor();
    case 1:
      return restitution.getDescriptor();
    default:
      return nullptr;
  }
}
