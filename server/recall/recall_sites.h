// Emergency recall: finds the stored sites that an aircraft without power can reach.
#pragma once

#include <functional>

#include <nlohmann/json_fwd.hpp>

#include "server/recall/emergency_request.h"
#include "server/recall/map_cache.h"
#include "storage/storage.h"

namespace freelsd {

// The data that recall reads: storage, and a cache of maps.
struct StoredSites {
  const Storage& storage;
  MapCache& maps;
  // Called before each site, map or moment that is evaluated; to give up, it throws.
  std::function<void()> stop_if_unwanted = [] {};
};

// Returns {sites, nearest_miss?, warnings}. Thread-safe.
nlohmann::json RecallSites(const StoredSites& stored, const EmergencyRequest& request);

}  // namespace freelsd
