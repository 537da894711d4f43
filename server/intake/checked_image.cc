#include "server/intake/checked_image.h"

#include "server/intake/arrival_clock.h"

namespace freelsd {
namespace {

class DecoderSlot {
 public:
  explicit DecoderSlot(Intake& intake) : intake_(intake) { intake_.decoders.acquire(); }
  ~DecoderSlot() { intake_.decoders.release(); }
  DecoderSlot(const DecoderSlot&) = delete;
  DecoderSlot& operator=(const DecoderSlot&) = delete;

 private:
  Intake& intake_;
};

std::string SizeText(int width_px, int height_px) {
  return std::to_string(width_px) + "x" + std::to_string(height_px);
}

void RefuseOtherSize(const ImageHeader& header, const Camera& camera) {
  if (header.width_px == camera.width_px && header.height_px == camera.height_px) return;
  throw ApiError("ImageSizeMismatch",
                 "the image is " + SizeText(header.width_px, header.height_px) +
                     ", the camera expects " + SizeText(camera.width_px, camera.height_px));
}

}  // namespace

CheckedImage CheckImage(Intake& intake,
                        std::string_view bytes,
                        const std::optional<Camera>& camera) {
  CheckedImage image;
  image.header = SniffImage(bytes, intake.image_limits);
  if (camera) RefuseOtherSize(image.header, *camera);
  image.sha256 = Sha256Hex(bytes);
  image.tags = ReadImageTags(bytes, image.header);
  const DecoderSlot slot(intake);
  for (const std::string& warning : DecodeAndTell(bytes, intake.image_limits).warnings) {
    image.tags.warnings.push_back(warning);
  }
  return image;
}

std::optional<Camera> CameraOf(const FlightRow& flight) {
  if (!flight.rig_json.empty()) return ParseStoredFlightRig(flight.rig_json).rig.camera;
  return ParseStoredFlightRequest(flight.request_json).camera;
}

RigResolver::RigResolver(const FlightRow& flight, const std::optional<Camera>& side_camera)
    : request_(ParseStoredFlightRequest(flight.request_json)) {
  if (!request_.camera) request_.camera = side_camera;
  if (!flight.rig_json.empty()) resolved_ = ParseStoredFlightRig(flight.rig_json);
}

FlightRig RigResolver::RigFor(const CheckedImage& image) const {
  if (resolved_) return *resolved_;
  const std::optional<Camera> camera = request_.camera ? request_.camera : image.tags.camera;
  if (!camera) {
    const std::string& why = image.tags.why_no_camera;
    throw ApiError("NoCamera",
                   "the flight has no camera and the image's tags do not describe one" +
                       (why.empty() ? "" : ": " + why),
                   {{"/camera", "is needed for these images"}});
  }
  FlightRig rig;
  rig.rig.camera = *camera;
  if (request_.body_from_camera) rig.rig.body_from_camera = *request_.body_from_camera;
  return rig;
}

void RigResolver::CheckSize(const CheckedImage& image) const {
  RefuseOtherSize(image.header, RigFor(image).rig.camera);
}

void RigResolver::Admit(const CheckedImage& image, const FrameMeta& meta) {
  if (!meta.position) {
    const std::string& why = image.tags.why_no_position;
    throw ApiError("NoPosition",
                   "neither meta, poses, telemetry nor the image's tags give a position" +
                       (why.empty() ? "" : ": " + why));
  }
  FlightRig rig = RigFor(image);
  if (!resolved_) rig.origin = request_.origin.value_or(*meta.position);
  CheckSize(image);
  resolved_ = rig;
}

std::vector<std::string> RigResolver::RelevantWarnings(const CheckedImage& image) const {
  if (request_.camera && !image.tags.meta.position) return {};
  return image.tags.warnings;
}

std::string RigResolver::RigJson() const { return resolved_ ? FlightRigJson(*resolved_) : ""; }

FrameRow NewFrameRow(const std::string& flight_id,
                     const std::string& frame_id,
                     const std::string& sha256,
                     const FrameSources& sources) {
  FrameRow row;
  row.flight_id = flight_id;
  row.id = frame_id;
  row.sha256 = sha256;
  row.meta_json = FrameMetaJson(sources.given);
  row.tags_json = FrameMetaJson(sources.tags);
  row.arrived_at_us = ArrivalNowUs();
  return row;
}

}  // namespace freelsd
