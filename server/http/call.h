// One request as handlers receive it: ids from the path, query parameters, the body.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/http/body_reader.h"
#include "server/http/http_library.h"

namespace freelsd {

struct Call {
  const httplib::Request& request;
  BodyReader& body;
  // Values from the URL, by the names in the route's path.
  std::map<std::string, std::string> ids;

  const std::string& Id(const std::string& name) const { return ids.at(name); }
  // Nothing if the parameter is absent. Throws ApiError InvalidQuery if it is given twice.
  std::optional<std::string> Query(const std::string& name) const;
  // Throws ApiError InvalidQuery if the value is not one finite number.
  std::optional<double> QueryNumber(const std::string& name) const;
  // Throws ApiError InvalidQuery if the value is not one finite number, InvalidValue if it is not
  // an integer in digits alone.
  std::optional<int64_t> QueryInteger(const std::string& name) const;
  // False if the parameter is absent. Throws ApiError InvalidQuery if it is not true or false.
  bool QueryFlag(const std::string& name) const;
};

// Throws ApiError InvalidQuery with the parameter's name if the text is not one finite number.
double ParseQueryNumber(const std::string& text, const std::string& parameter);
// The same for numbers separated by commas; there is at least one.
std::vector<double> ParseQueryNumbers(const std::string& text, const std::string& parameter);

}  // namespace freelsd
