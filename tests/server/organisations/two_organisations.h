// A PostgreSQL database on which the organisation "north" has something of everything, and a server
// with tokens of it and of "south", which has nothing.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/http/http_library.h"
#include "tests/server/test_server.h"
#include "tests/storage/place.h"

namespace freelsd {

// The ids, and all texts that "north" has written, begin with this.
inline constexpr char kSecret[] = "north-";

struct TwoOrganisations {
  explicit TwoOrganisations(const std::function<void(Config& config)>& change = {});

  // With all scopes.
  httplib::Client As(const std::string& organisation) const;

  StoragePlace place;
  // Of the process that has filled the database.
  std::unique_ptr<Storage> storage;
  std::unique_ptr<Storage> north;
  std::unique_ptr<TestServer> server;
};

}  // namespace freelsd
