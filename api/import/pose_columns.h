// Which column of a pose file means what.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/import/csv.h"

namespace freelsd {

enum class PoseField {
  kImage,
  kLatitude,
  kLongitude,
  kAltitude,
  kTimestamp,
  kDateTime,
  kRoll,
  kPitch,
  kYaw,
  kQuaternionW,
  kQuaternionX,
  kQuaternionY,
  kQuaternionZ,
  kGimbalRoll,
  kGimbalPitch,
  kGimbalYaw,
  kImageUpHeading,
  kWindEast,
  kWindNorth,
  kWindFrom,
  kWindTo,
  kWindSpeed,
  kHeightAboveGround,
  kHeightAboveTakeOff,
  kPositionSd,
  kAttitudeSd,
};

// Hamilton, w first, ned_from_body: one attitude in four columns.
constexpr std::array<PoseField, 4> kQuaternionFields{PoseField::kQuaternionW,
                                                     PoseField::kQuaternionX,
                                                     PoseField::kQuaternionY,
                                                     PoseField::kQuaternionZ};

// The contract's name of a field.
std::string_view NameOf(PoseField field);
// Its place in a frame's meta ("/position/latitude_deg"); empty where meta has no such key.
std::string_view MetaPointerOf(PoseField field);

struct PoseColumns {
  struct Column {
    size_t index = 0;
    std::string name;  // as in the file, harmless to print
  };
  std::map<PoseField, Column> columns;
  // Spreadsheets leave such behind; any number of them.
  std::vector<size_t> unnamed;
  std::vector<std::string> warnings;
};
// How many of the cells name a field.
size_t NumKnownColumns(const std::vector<std::string>& cells);
// The same of a line that may be no header, split at every comma, semicolon and tab.
size_t NumKnownColumns(std::string_view line);
// Names in any order and case. What is not understood is a warning; a field given twice under other
// names is taken from the better known one. Throws ApiError InvalidPoses when the same name comes
// twice or one of the first four fields is missing.
PoseColumns ReadHeader(const CsvLine& line);

}  // namespace freelsd
