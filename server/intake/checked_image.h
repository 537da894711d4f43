// Checks an uploaded image, and determines the camera and the origin of its flight.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/api.h"
#include "api/import/images/images.h"
#include "api/import/import.h"
#include "api/stored/stored.h"
#include "server/intake/state.h"

namespace freelsd {

// The data of an image that passed the check.
struct CheckedImage {
  std::string sha256;
  ImageHeader header;
  ImageTags tags;
};

// Decodes the image completely, so that every stored image is usable. If `camera` is given, an
// image of another size is rejected by its header, before decoding. Throws ApiError.
CheckedImage CheckImage(Intake& intake,
                        std::string_view bytes,
                        const std::optional<Camera>& camera = std::nullopt);
// The camera of the flight; nothing while it is unknown.
std::optional<Camera> CameraOf(const FlightRow& flight);

// Determines a flight's rig (camera, mounting) and origin. The first admitted image fixes what the
// flight's request left open.
class RigResolver {
 public:
  // `side_camera`: camera from a calibration file beside the images. Precedence: the flight's own
  // camera, `side_camera`, the images' tags.
  explicit RigResolver(const FlightRow& flight,
                       const std::optional<Camera>& side_camera = std::nullopt);
  // `meta` must be merged with the image's tags. Throws ApiError NoPosition, NoCamera or
  // ImageSizeMismatch, and leaves the resolver unchanged.
  void Admit(const CheckedImage& image, const FrameMeta& meta);
  // Checks only the size of the image. Used for a frame whose position will come from telemetry.
  // Throws ApiError ImageSizeMismatch.
  void CheckSize(const CheckedImage& image) const;
  // Warnings about the image's tags. None if the flight has its own camera and the image has no
  // geotag, because the tags are not used then.
  std::vector<std::string> RelevantWarnings(const CheckedImage& image) const;
  // The new value of FlightRow::rig_json; empty before the first admitted image.
  std::string RigJson() const;

 private:
  FlightRig RigFor(const CheckedImage& image) const;

  FlightRequest request_;
  std::optional<FlightRig> resolved_;
};

// Metadata from the client, and from the image's tags.
struct FrameSources {
  FrameMeta given;
  FrameMeta tags;
};
FrameRow NewFrameRow(const std::string& flight_id,
                     const std::string& frame_id,
                     const std::string& sha256,
                     const FrameSources& sources);

}  // namespace freelsd
