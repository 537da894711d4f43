// A stored site on a known map, and a server that has it.
#pragma once

#include <memory>

#include "api/export/layers/layers.h"
#include "api/stored/stored.h"
#include "server/handlers/lookups.h"
#include "tests/server/test_server.h"

namespace freelsd {

// A flat, grassy, wholly seen square of 600 m about the origin.
SiteMap Meadow();
// On it, at 47 N 8 E, 400 m in `altitude_datum`, or so far north of there; unverified, for the
// small aircraft.
SiteRow MeadowSite(const std::string& altitude_datum = "unknown", double north_m = 0.0);

// Of a site whose final is blocked on the map of that site.
Standing SupersededBy(const std::string& site_id);

// A server whose folder already holds the meadow, and a site without a map.
struct MeadowServer {
  TemporaryFolder folder;
  std::unique_ptr<TestServer> server;
  std::unique_ptr<httplib::Client> client;

  explicit MeadowServer(const std::function<void(Storage&)>& fill = {},
                        const std::function<void(Config&)>& change = {});
};

}  // namespace freelsd
