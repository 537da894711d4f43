// Intrinsics from an image's tags.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/import/images/images.h"
#include "api/import/images/tag_source.h"

namespace freelsd {

struct TaggedCamera {
  std::optional<Camera> camera;
  std::vector<std::string> warnings;
};
// A calibration in XMP gives a camera of source kCalibrated, with focal length, principal point and
// distortion. Focal length and principal point are converted from millimetres by the pixel pitch in
// EXIF. A focal length in EXIF gives a camera of source kExif, without distortion, and with the
// principal point in the image's centre.
TaggedCamera CameraFromTags(const TagSource& tags, const ImageHeader& header);

}  // namespace freelsd
