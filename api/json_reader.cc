#include "api/json_reader.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace freelsd {
namespace {

// Larger integers are not exact in a double, and JavaScript has only doubles.
constexpr double kMaxExactInteger = 9007199254740992.0;
constexpr double kMinQuaternionNorm = 0.99;
constexpr double kMaxQuaternionNorm = 1.01;
constexpr size_t kMaxShownKeyBytes = 100;
constexpr double kUnitNormTolerance = 1e-12;
// Bound of fields without their own range. No quantity of the contract is larger, and its square
// is still finite.
constexpr double kLargestNumber = 1e12;
// From below the Dead Sea to above the ceiling of small planes.
constexpr NumberRange kAltitudeRange{-1000.0, 20000.0};
constexpr NumberRange kLatitudeRange{-90.0, 90.0};
// Characters whose UTF-8 begins with `lead` and ends with a byte from `first` to `last`.
struct CharacterRange {
  std::string_view lead;
  char first;
  char last;
};
constexpr CharacterRange kControlCharacters[] = {
    {"\xC2", '\x80', '\x9F'},      // U+0080 to U+009F: control
    {"\xD8", '\x9C', '\x9C'},      // U+061C: direction
    {"\xE2\x80", '\x8E', '\x8F'},  // U+200E, U+200F: direction
    {"\xE2\x80", '\xA8', '\xAE'},  // U+2028 to U+202E: line breaks, direction
    {"\xE2\x81", '\xA6', '\xA9'},  // U+2066 to U+2069: direction
};
constexpr NumberRange kLongitudeRange{-180.0, 180.0};

// Refuses what the parser accepts: deep nesting (destructor and dump() recurse) and duplicate keys
// (the parser would silently keep the last value).
class StrictCallback {
 public:
  bool operator()(int depth, nlohmann::json::parse_event_t event, const nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    if (event == Event::object_start || event == Event::array_start) {
      if (depth >= kLimits.json.max_depth) {
        throw ApiError("InvalidJson",
                       "nested deeper than " + std::to_string(kLimits.json.max_depth));
      }
      if (event == Event::object_start) keys_.emplace_back();
    } else if (event == Event::object_end) {
      keys_.pop_back();
    } else if (event == Event::key && !keys_.back().insert(parsed.get<std::string>()).second) {
      throw ApiError("InvalidJson", "a key is given twice in one object");
    }
    return true;
  }

 private:
  std::vector<std::set<std::string>> keys_;
};

std::string Escaped(const std::string& key) {
  std::string escaped;
  for (const char c : key) {
    if (c == '~') {
      escaped += "~0";
    } else if (c == '/') {
      escaped += "~1";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string LastToken(const std::string& pointer) {
  return pointer.substr(pointer.find_last_of('/') + 1);
}

double ReadLatitude(ObjectReader& reader, const std::string& pointer) {
  try {
    return reader.RequiredNumber("latitude_deg", kLatitudeRange);
  } catch (const ApiError& error) {
    const auto is_within = [&reader](const char* key, double limit) {
      const nlohmann::json* const value = reader.Find(key);
      return value != nullptr && value->is_number() && std::abs(value->get<double>()) <= limit;
    };
    // Each number must lie in the range of the other one.
    const bool can_be_swapped = is_within("latitude_deg", kLongitudeRange.max) &&
                                is_within("longitude_deg", kLatitudeRange.max);
    if (!can_be_swapped) throw;
    throw InvalidValue(pointer + "/latitude_deg",
                       std::string(error.what()) + ": latitude and longitude may be swapped");
  }
}

}  // namespace

nlohmann::json ParseJson(const std::string& text, size_t max_bytes) {
  if (text.size() > max_bytes) {
    ApiError error("JsonTooLarge",
                   "the JSON has " + std::to_string(text.size()) + " bytes, the limit is " +
                       std::to_string(max_bytes));
    error.limit = static_cast<double>(max_bytes);
    error.observed = static_cast<double>(text.size());
    throw error;
  }
  // The parser takes a NUL byte for the end of the text.
  if (const size_t nul = text.find('\0'); nul != std::string::npos) {
    throw ApiError("InvalidJson", "not JSON at byte " + std::to_string(nul + 1));
  }
  StrictCallback strict;
  try {
    return nlohmann::json::parse(
        text, [&strict](int depth, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
          return strict(depth, event, parsed);
        });
  } catch (const nlohmann::json::parse_error& error) {
    throw ApiError("InvalidJson", "not JSON at byte " + std::to_string(error.byte));
  } catch (const nlohmann::json::exception&) {
    // The parser fails otherwise only for a number that no double can hold.
    throw ApiError("InvalidJson", "a number is out of range");
  }
}

ApiError InvalidValue(const std::string& pointer, const std::string& detail) {
  return ApiError("InvalidValue", detail, {{pointer, detail}});
}

ApiError FromCheck(const std::invalid_argument& error,
                   const std::string& pointer,
                   const std::string& owner) {
  std::string field = error.what();
  field = field.substr(0, field.find(" = "));
  if (field.find(' ') != std::string::npos) return InvalidValue(pointer, error.what());
  if (field.rfind(owner, 0) == 0) field = field.substr(owner.size());
  for (char& c : field) c = c == '.' ? '/' : c;
  return InvalidValue(pointer + "/" + field, error.what());
}

double ReadNumber(const nlohmann::json& value,
                  const std::string& pointer,
                  const NumberRange& range) {
  if (!value.is_number()) {
    throw InvalidValue(pointer, LastToken(pointer) + ": must be a number");
  }
  const double number = value.get<double>();
  const double min = std::max(range.min, -kLargestNumber);
  const double max = std::min(range.max, kLargestNumber);
  if (number >= min && number <= max) return number;
  std::ostringstream detail;
  detail << LastToken(pointer) << " = " << number << ": must be in [" << min << ", " << max << "]";
  throw InvalidValue(pointer, detail.str());
}

int64_t ReadInteger(const nlohmann::json& value, const std::string& pointer) {
  const bool fits = value.is_number_unsigned()
                        ? value.get<uint64_t>() <= static_cast<uint64_t>(kMaxExactInteger)
                        : value.is_number_integer() || value.is_number_float();
  const double number = fits ? value.get<double>() : 0.0;
  if (fits && std::abs(number) <= kMaxExactInteger && number == std::floor(number)) {
    return value.is_number_float() ? static_cast<int64_t>(number) : value.get<int64_t>();
  }
  throw InvalidValue(pointer, LastToken(pointer) + ": must be an integer of at most 2^53");
}

std::string ReadString(const nlohmann::json& value, const std::string& pointer) {
  if (!value.is_string()) throw InvalidValue(pointer, LastToken(pointer) + ": must be a string");
  return value.get<std::string>();
}

bool HasControlCharacter(std::string_view text) {
  const auto is_ascii_control = [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
  };
  if (std::any_of(text.begin(), text.end(), is_ascii_control)) return true;
  return std::any_of(
      std::begin(kControlCharacters), std::end(kControlCharacters), [text](const auto& range) {
        for (size_t at = text.find(range.lead); at != std::string_view::npos;
             at = text.find(range.lead, at + 1)) {
          const size_t last = at + range.lead.size();
          if (last < text.size() && text[last] >= range.first && text[last] <= range.last) {
            return true;
          }
        }
        return false;
      });
}

bool ReadBoolean(const nlohmann::json& value, const std::string& pointer) {
  if (!value.is_boolean()) {
    throw InvalidValue(pointer, LastToken(pointer) + ": must be true or false");
  }
  return value.get<bool>();
}

std::vector<double> ReadNumbers(const nlohmann::json& value,
                                const std::string& pointer,
                                std::optional<size_t> size) {
  if (!value.is_array() || (size && value.size() != *size)) {
    const std::string count = size ? " of " + std::to_string(*size) + " numbers" : " of numbers";
    throw InvalidValue(pointer, LastToken(pointer) + ": must be an array" + count);
  }
  std::vector<double> numbers;
  for (size_t i = 0; i < value.size(); ++i) {
    numbers.push_back(ReadNumber(value[i], pointer + "/" + std::to_string(i), {}));
  }
  return numbers;
}

Eigen::Quaterniond ReadQuaternion(const nlohmann::json& value, const std::string& pointer) {
  const std::vector<double> wxyz = ReadNumbers(value, pointer, 4);
  Eigen::Quaterniond quaternion(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  const double norm = quaternion.norm();
  // A normalised quaternion keeps its bits: stored poses must not change when they are read again.
  if (std::abs(norm - 1.0) < kUnitNormTolerance) return quaternion;
  if (norm >= kMinQuaternionNorm && norm <= kMaxQuaternionNorm) return quaternion.normalized();
  std::ostringstream detail;
  detail << LastToken(pointer) << ": its norm is " << norm << ", must be in [" << kMinQuaternionNorm
         << ", " << kMaxQuaternionNorm << "]";
  throw InvalidValue(pointer, detail.str());
}

GeoPoint ReadGeoPoint(const nlohmann::json& value, const std::string& pointer) {
  ObjectReader reader(value, pointer);
  reader.RefuseKeysExcept({"latitude_deg", "longitude_deg", "altitude_m"});
  GeoPoint point;
  point.latitude_deg = ReadLatitude(reader, pointer);
  point.longitude_deg = reader.RequiredNumber("longitude_deg", kLongitudeRange);
  point.altitude_m = reader.RequiredNumber("altitude_m", kAltitudeRange);
  reader.RefuseUnknownKeys();
  return point;
}

nlohmann::json GeoPointJson(const GeoPoint& point) {
  return {{"latitude_deg", point.latitude_deg},
          {"longitude_deg", point.longitude_deg},
          {"altitude_m", point.altitude_m}};
}

nlohmann::json QuaternionJson(const Eigen::Quaterniond& quaternion) {
  // Adding zero turns -0 into 0, so that equal attitudes give equal text.
  return {quaternion.w() + 0.0, quaternion.x() + 0.0, quaternion.y() + 0.0, quaternion.z() + 0.0};
}

ObjectReader::ObjectReader(const nlohmann::json& value, std::string pointer)
    : value_(value), pointer_(std::move(pointer)) {
  if (!value.is_object()) {
    const std::string name = pointer_.empty() ? "the body" : LastToken(pointer_);
    throw InvalidValue(pointer_, name + ": must be an object");
  }
}

const nlohmann::json* ObjectReader::Find(const std::string& key) {
  asked_.insert(key);
  const auto found = value_.find(key);
  return found == value_.end() || found->is_null() ? nullptr : &*found;
}

const nlohmann::json& ObjectReader::Required(const std::string& key) {
  const nlohmann::json* const found = Find(key);
  if (found == nullptr) throw InvalidValue(PointerTo(key), key + ": is needed");
  return *found;
}

std::optional<double> ObjectReader::Number(const std::string& key, const NumberRange& range) {
  const nlohmann::json* const found = Find(key);
  if (found == nullptr) return std::nullopt;
  return ReadNumber(*found, PointerTo(key), range);
}

double ObjectReader::RequiredNumber(const std::string& key, const NumberRange& range) {
  return ReadNumber(Required(key), PointerTo(key), range);
}

std::string ObjectReader::PointerTo(const std::string& key) const {
  return pointer_ + "/" + Escaped(key);
}

void ObjectReader::RefuseUnknownKeys() const { RefuseKeysExcept(asked_); }

void ObjectReader::RefuseKeysExcept(const std::set<std::string>& known) const {
  for (const auto& item : value_.items()) {
    if (known.count(item.key()) != 0) continue;
    const bool is_long = item.key().size() > kMaxShownKeyBytes;
    const std::string detail = "the key \"" + (is_long ? "..." : item.key()) + "\" is unknown";
    throw ApiError("UnknownKey", detail, {{PointerTo(item.key()), detail}});
  }
}

}  // namespace freelsd
