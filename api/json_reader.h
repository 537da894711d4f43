// Strict reading of JSON. The caller reads each value by key, with its type and range. Keys that
// are never read are errors. All errors are ApiError with a JSON pointer.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

struct NumberRange {
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
};

// ApiError InvalidValue (422) with one pointer.
ApiError InvalidValue(const std::string& pointer, const std::string& detail);
// Turns the message of an engine's Check(), "owner.field = value: constraint", into an ApiError
// with pointer <pointer>/field. `owner`, for example "camera.", is the prefix to remove; it may be
// empty.
ApiError FromCheck(const std::invalid_argument& error,
                   const std::string& pointer,
                   const std::string& owner);

double ReadNumber(const nlohmann::json& value,
                  const std::string& pointer,
                  const NumberRange& range);
int64_t ReadInteger(const nlohmann::json& value, const std::string& pointer);
std::string ReadString(const nlohmann::json& value, const std::string& pointer);
// True if the text, UTF-8, cannot be shown on one line as it is: control characters, line breaks,
// and characters that change the direction of writing, so that a name reads as another one.
bool HasControlCharacter(std::string_view text);
bool ReadBoolean(const nlohmann::json& value, const std::string& pointer);
// Array of finite numbers; exactly `size` of them, if given.
std::vector<double> ReadNumbers(const nlohmann::json& value,
                                const std::string& pointer,
                                std::optional<size_t> size);
// Reads [w, x, y, z] with a norm of 0.99 to 1.01 and normalises it.
Eigen::Quaterniond ReadQuaternion(const nlohmann::json& value, const std::string& pointer);
GeoPoint ReadGeoPoint(const nlohmann::json& value, const std::string& pointer);
nlohmann::json QuaternionJson(const Eigen::Quaterniond& quaternion);

class ObjectReader {
 public:
  // Throws ApiError unless `value` is an object. Keeps a reference to `value`.
  ObjectReader(const nlohmann::json& value, std::string pointer);

  // Throws ApiError UnknownKey if the object has any other key. Call it first if a key is required.
  // The error then names the misspelt key instead of the missing one.
  void RefuseKeysExcept(const std::set<std::string>& known) const;
  // Null counts as absent.
  const nlohmann::json* Find(const std::string& key);
  const nlohmann::json& Required(const std::string& key);
  std::optional<double> Number(const std::string& key, const NumberRange& range = {});
  double RequiredNumber(const std::string& key, const NumberRange& range = {});
  std::string PointerTo(const std::string& key) const;
  // Call last. Throws ApiError UnknownKey if the object has a key that was never read.
  void RefuseUnknownKeys() const;

 private:
  const nlohmann::json& value_;
  std::string pointer_;
  std::set<std::string> asked_;
};

}  // namespace freelsd
