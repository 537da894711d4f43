#include "server/intake/stored_images.h"

#include <stdexcept>

#include "api/import/images/images.h"

namespace freelsd {

cv::Mat StoredImage(const Intake& intake, const FrameRow& frame) {
  try {
    const std::optional<std::string> bytes = intake.storage.images.Read(frame.sha256);
    return bytes ? DecodeImage(*bytes, intake.image_limits) : cv::Mat();
  } catch (const StorageError&) {
    throw;
  } catch (const std::exception& error) {
    throw std::runtime_error("the photograph " + frame.id + ": " + error.what());
  }
}

ImageSource StoredImages(const Intake& intake, const std::string& flight_id) {
  return [&intake, flight_id](const std::string& frame_id) {
    const std::optional<FrameRow> frame = intake.storage.frames.Find(flight_id, frame_id);
    return frame ? StoredImage(intake, *frame) : cv::Mat();
  };
}

}  // namespace freelsd
