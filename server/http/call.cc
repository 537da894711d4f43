#include "server/http/call.h"

#include <charconv>
#include <cmath>
#include <sstream>

#include "api/api.h"

namespace freelsd {

double ParseQueryNumber(const std::string& text, const std::string& parameter) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stopped_at, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped_at != end || !std::isfinite(value)) {
    const std::string detail = parameter + ": must be a finite number";
    throw ApiError("InvalidQuery", detail, {{parameter, detail}});
  }
  return value;
}

std::vector<double> ParseQueryNumbers(const std::string& text, const std::string& parameter) {
  std::vector<double> numbers;
  // getline leaves out an empty last part, unless a comma follows it.
  std::istringstream list(text + ",");
  for (std::string part; std::getline(list, part, ',');) {
    numbers.push_back(ParseQueryNumber(part, parameter));
  }
  return numbers;
}

std::optional<std::string> Call::Query(const std::string& name) const {
  const size_t count = request.get_param_value_count(name);
  if (count == 0) return std::nullopt;
  if (count > 1) {
    throw ApiError("InvalidQuery", name + ": is given twice", {{name, "is given twice"}});
  }
  return request.get_param_value(name);
}

std::optional<double> Call::QueryNumber(const std::string& name) const {
  const std::optional<std::string> text = Query(name);
  if (!text) return std::nullopt;
  return ParseQueryNumber(*text, name);
}

std::optional<int64_t> Call::QueryInteger(const std::string& name) const {
  const std::optional<std::string> text = Query(name);
  if (!text) return std::nullopt;
  ParseQueryNumber(*text, name);
  int64_t value = 0;
  const char* const end = text->data() + text->size();
  const auto [stopped_at, error] = std::from_chars(text->data(), end, value);
  if (error == std::errc() && stopped_at == end) return value;
  throw ApiError("InvalidValue", name + ": must be an integer", {{name, "must be an integer"}});
}

bool Call::QueryFlag(const std::string& name) const {
  const std::string text = Query(name).value_or("false");
  if (text != "true" && text != "false") {
    throw ApiError("InvalidQuery", name + ": must be true or false", {{name, "true or false"}});
  }
  return text == "true";
}

}  // namespace freelsd
