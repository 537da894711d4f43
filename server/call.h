// One request as its handler sees it: ids from the path, checked query parameters, the body.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "server/body_reader.h"
#include "server/http_library.h"

namespace freelsd {

struct Call {
  const httplib::Request& request;
  BodyReader& body;
  // By the names in the route's path.
  std::map<std::string, std::string> ids;

  const std::string& Id(const std::string& name) const { return ids.at(name); }
  // Nothing when absent. Throws ApiError InvalidQuery when given twice.
  std::optional<std::string> Query(const std::string& name) const;
  // Throws ApiError InvalidQuery for what is not one finite number.
  std::optional<double> QueryNumber(const std::string& name) const;
  bool QueryFlag(const std::string& name) const;
};

// One finite number and nothing else. Throws ApiError InvalidQuery naming the parameter.
double ParseQueryNumber(const std::string& text, const std::string& parameter);

}  // namespace freelsd
