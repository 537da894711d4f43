// Strict reading of JSON: every value is asked for by key, type and range; what is not asked for is
// refused. All errors are ApiError with a pointer.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

struct NumberRange {
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
};

// ApiError InvalidValue (422) at one place.
ApiError InvalidValue(const std::string& pointer, const std::string& detail);
// What a Check() of the engine says, "owner.field = value: constraint", as ApiError at
// <pointer>/field; `owner` ("camera.") is cut off, empty keeps all.
ApiError FromCheck(const std::invalid_argument& error,
                   const std::string& pointer,
                   const std::string& owner);

double ReadNumber(const nlohmann::json& value,
                  const std::string& pointer,
                  const NumberRange& range);
int64_t ReadInteger(const nlohmann::json& value, const std::string& pointer);
std::string ReadString(const nlohmann::json& value, const std::string& pointer);
bool ReadBoolean(const nlohmann::json& value, const std::string& pointer);
// Array of exactly `size` finite numbers.
std::vector<double> ReadNumbers(const nlohmann::json& value,
                                const std::string& pointer,
                                std::optional<size_t> size);
// [w, x, y, z] with a norm of 0.99 to 1.01; normalised.
Eigen::Quaterniond ReadQuaternion(const nlohmann::json& value, const std::string& pointer);
GeoPoint ReadGeoPoint(const nlohmann::json& value, const std::string& pointer);
nlohmann::json QuaternionJson(const Eigen::Quaterniond& quaternion);

class ObjectReader {
 public:
  // ApiError unless `value` is an object. Keeps a reference to it.
  ObjectReader(const nlohmann::json& value, std::string pointer);

  // Null counts as absent.
  const nlohmann::json* Find(const std::string& key);
  const nlohmann::json& Required(const std::string& key);
  std::optional<double> Number(const std::string& key, const NumberRange& range = {});
  double RequiredNumber(const std::string& key, const NumberRange& range = {});
  std::string PointerTo(const std::string& key) const;
  // To be called last: ApiError UnknownKey for a key that was never asked for.
  void RefuseUnknownKeys() const;

 private:
  const nlohmann::json& value_;
  std::string pointer_;
  std::set<std::string> asked_;
};

}  // namespace freelsd
