// Intrinsics from an image's tags.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/import/import.h"
#include "api/import/tag_source.h"

namespace freelsd {

struct TaggedCamera {
  std::optional<Camera> camera;
  std::vector<std::string> warnings;
};
// A calibration in XMP (focal length, principal point and distortion in millimetres, with the pixel
// pitch of EXIF) is kCalibrated; a focal length of EXIF is kExif, without distortion and with the
// principal point in the middle.
TaggedCamera CameraFromTags(const TagSource& tags, const ImageHeader& header);

}  // namespace freelsd
