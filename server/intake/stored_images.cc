#include "server/intake/stored_images.h"

#include "api/import/images/images.h"

namespace freelsd {

ImageSource StoredImages(const Intake& intake, const std::string& flight_id) {
  return [&intake, flight_id](const std::string& frame_id) {
    const std::optional<FrameRow> frame = intake.storage.frames.Find(flight_id, frame_id);
    if (!frame) return cv::Mat();
    const std::optional<std::string> bytes = intake.storage.images.Read(frame->sha256);
    if (!bytes) return cv::Mat();
    return DecodeImage(*bytes, intake.image_limits);
  };
}

}  // namespace freelsd
