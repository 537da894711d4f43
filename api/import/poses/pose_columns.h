// Meaning of a pose file's columns.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/import/poses/csv.h"

namespace freelsd {

enum class PoseField {
  kImage,
  kLatitude,
  kLongitude,
  kAltitude,
  kLatitudeRef,
  kLongitudeRef,
  kAltitudeRef,
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

// Columns of one quaternion: ned_from_body, Hamilton convention, w first.
constexpr std::array<PoseField, 4> kQuaternionFields{PoseField::kQuaternionW,
                                                     PoseField::kQuaternionX,
                                                     PoseField::kQuaternionY,
                                                     PoseField::kQuaternionZ};

// Name of a field in openapi.yaml.
std::string_view NameOf(PoseField field);
// The field's pointer in a frame's meta ("/position/latitude_deg"); empty if meta has no such key.
std::string_view MetaPointerOf(PoseField field);

struct PoseColumns {
  struct Column {
    size_t index = 0;
    std::string name;  // as in the file, made safe to print
  };
  std::map<PoseField, Column> columns;
  // Indices of columns without a name. Spreadsheets may write any number of them.
  std::vector<size_t> unnamed;
  std::vector<std::string> warnings;

  // Datum of the altitude, "amsl" or "ellipsoid", if the name of its column tells it.
  std::optional<std::string> AltitudeDatum() const;
};
// Number of cells that name a field.
size_t NumKnownColumns(const std::vector<std::string>& cells);
// Like the function above, for any line of text. The line is split at every comma, semicolon and
// tab.
size_t NumKnownColumns(std::string_view line);
// Names may have any order and case. An unknown name causes a warning. If several columns name one
// field, the name listed first in pose_columns.cc is used. Throws ApiError InvalidPoses if a name
// occurs twice or if one of the first four fields of PoseField is missing.
PoseColumns ReadHeader(const CsvLine& line);

}  // namespace freelsd
