// Checks an uploaded image, and resolves the camera and the origin of its flight.
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

// Decodes the image strictly, so that every stored image can be used. With a camera, refuses an
// image of another size by its header, before it unpacks pixels. Throws ApiError.
CheckedImage CheckImage(Intake& intake,
                        std::string_view bytes,
                        const std::optional<Camera>& camera = std::nullopt);
// The camera of the flight's images; nothing if it is not known yet.
std::optional<Camera> CameraOf(const FlightRow& flight);

// Resolves a flight's rig (camera, mounting, origin). The first admitted image settles what the
// flight's request left open.
class RigResolver {
 public:
  // `side_camera`: from a calibration file beside the images. Precedence: the flight's own camera,
  // then `side_camera`, then the images' tags.
  explicit RigResolver(const FlightRow& flight,
                       const std::optional<Camera>& side_camera = std::nullopt);
  // Throws ApiError NoPosition, NoCamera or ImageSizeMismatch; the resolver is unchanged then.
  // `meta`: merged with the image's tags.
  void Admit(const CheckedImage& image, const FrameMeta& meta);
  // The check of the size alone, for a frame whose position telemetry will give. Resolves nothing.
  void CheckSize(const CheckedImage& image) const;
  // Warnings about the image's tags if the flight uses the tags. It uses none of them if the image
  // has no geotag and the flight has its own camera.
  std::vector<std::string> RelevantWarnings(const CheckedImage& image) const;
  // The new value of FlightRow::rig_json.
  std::string RigJson() const;

 private:
  FlightRig RigFor(const CheckedImage& image) const;

  FlightRequest request_;
  std::optional<FlightRig> resolved_;
};

// `given`: metadata from the client, without the image's tags.
FrameRow NewFrameRow(const std::string& flight_id,
                     const std::string& frame_id,
                     const CheckedImage& image,
                     const FrameMeta& given);

}  // namespace freelsd
