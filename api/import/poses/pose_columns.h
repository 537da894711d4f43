// Meaning of the columns of a table of poses. Private to poses/.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/import/poses/measure.h"
#include "api/import/poses/table.h"

namespace freelsd {

enum class PoseField {
  kImage,
  kLatitude,
  kLongitude,
  kAltitude,
  // Easting or longitude, and northing or latitude: the coordinate system tells.
  kX,
  kY,
  // Both, in one cell.
  kLatitudeLongitude,
  // Hemispheres, and below sea level, of unsigned numbers.
  kLatitudeRef,
  kLongitudeRef,
  kAltitudeRef,
  kTime,
  kRoll,
  kPitch,
  kYaw,
  // Of photogrammetry.
  kOmega,
  kPhi,
  kKappa,
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

// Angles that are 0, 0, 0 where nobody measured them.
constexpr std::array<PoseField, 7> kAngleFields{PoseField::kRoll,
                                                PoseField::kPitch,
                                                PoseField::kYaw,
                                                PoseField::kImageUpHeading,
                                                PoseField::kGimbalRoll,
                                                PoseField::kGimbalPitch,
                                                PoseField::kGimbalYaw};

// Name of a field in openapi.yaml.
std::string_view NameOf(PoseField field);
// The field's pointer in a frame's meta ("/position/latitude_deg"); empty if meta has no such key.
std::string_view MetaPointerOf(PoseField field);
Quantity QuantityOf(PoseField field);

struct PoseColumns {
  struct Column {
    size_t index = 0;
    std::string name;  // as in the file, made safe to print
    // The unit in its name.
    std::optional<Unit> unit;
  };
  std::map<PoseField, Column> columns;
  // Indices of columns without a name. Spreadsheets may write any number of them.
  std::vector<size_t> unnamed;
  std::vector<std::string> warnings;
  // Standard deviation of attitudes without their own.
  std::optional<double> attitude_sd_deg;

  bool Has(PoseField field) const { return columns.contains(field); }
  // Datum of the altitude, "amsl" or "ellipsoid", if the name of its column tells it.
  std::optional<std::string> AltitudeDatum() const;
};
// Number of cells that name a field.
size_t NumKnownColumns(const std::vector<std::string>& cells);
// Finds columns by the words of their names ("GPS Altitude [ft]"), and that of the images also by
// its cells, of a table with a header. Throws ApiError InvalidPoses if
// there is no image or place, or if two columns of one used name differ.
PoseColumns ReadHeader(const Table& table);

}  // namespace freelsd
