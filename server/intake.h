// What every way of sending images has in common: checking an image, and placing it in its flight.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/api.h"
#include "api/import/import.h"
#include "server/service.h"

namespace freelsd {

struct CheckedImage {
  std::string sha256;
  ImageHeader header;
  ImageTags tags;
};

// Decodes strictly, so that what is stored can be used. With a camera, an image of another size is
// refused by its header: nothing of its pixels is unpacked. Throws ApiError.
CheckedImage CheckImage(Service& service,
                        std::string_view bytes,
                        const std::optional<Camera>& camera = std::nullopt);
// Of the flight's images, where it is known before they come.
std::optional<Camera> CameraOf(const FlightRow& flight);

// What a flight's frames are placed with; the first admitted image decides what the request left
// open.
class RigResolver {
 public:
  // `side_camera`: of a calibration that came beside the images; the flight's own wins over it, and
  // it over the images' tags.
  explicit RigResolver(const FlightRow& flight,
                       const std::optional<Camera>& side_camera = std::nullopt);
  // Throws ApiError NoPosition, NoCamera or ImageSizeMismatch; nothing has changed then. `meta`:
  // with the image's tags.
  void Admit(const CheckedImage& image, const FrameMeta& meta);
  // The same of a frame whose position is to come from telemetry: it resolves nothing.
  void CheckSize(const CheckedImage& image) const;
  // What the image's tags warn of, where they are used: an image without geotag in a flight with a
  // camera of its own has no tags that matter.
  std::vector<std::string> RelevantWarnings(const CheckedImage& image) const;
  // What FlightRow::rig_json should be now.
  std::string RigJson() const;

 private:
  FlightRig RigFor(const CheckedImage& image) const;

  FlightRequest request_;
  std::optional<FlightRig> resolved_;
};

// `given`: without the image's tags.
FrameRow NewFrameRow(const std::string& flight_id,
                     const std::string& frame_id,
                     const CheckedImage& image,
                     const FrameMeta& given);

}  // namespace freelsd
