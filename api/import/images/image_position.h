// Where a photograph was taken, from its tags. Private to images/.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/import/images/tag_source.h"
#include "engine/geometry/geometry.h"

namespace freelsd {

struct TaggedPosition {
  std::optional<GeoPoint> place;
  // "amsl" or "ellipsoid"; nothing if it is not told.
  std::optional<std::string> altitude_datum;
  std::vector<std::string> warnings;
  // Why a geotag is not used; empty if there is none.
  std::string why_not;
};
// The place of EXIF. XMP's is used where EXIF has none, or an impossible one.
TaggedPosition PositionFromTags(const TagSource& tags);

}  // namespace freelsd
