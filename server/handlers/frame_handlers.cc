#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/http/http.h"
#include "server/intake/intake.h"

namespace freelsd {
namespace {

// Size of boundaries and part headers around an image and its meta.
constexpr size_t kMultipartOverheadBytes = 64 << 10;

void TakePart(MultipartReader& parts, const std::string& name, size_t max_bytes, std::string& to) {
  std::optional<std::string> content = parts.ReadAll(max_bytes);
  if (!content) {
    ApiError error(
        "BodyTooLarge", "the part " + name + " is too large", {{"/" + name, "too large"}});
    error.limit = static_cast<double>(max_bytes);
    throw error;
  }
  to = std::move(*content);
}

FrameUpload ParseMultipart(const std::string& body, const std::string& boundary, size_t max_bytes) {
  size_t position = 0;
  MultipartReader parts(
      [&body, &position](char* bytes, size_t size) {
        const size_t num_read = body.copy(bytes, size, position);
        position += num_read;
        return num_read;
      },
      boundary);
  FrameUpload upload;
  bool has_image = false;
  bool has_meta = false;
  while (const std::optional<Part> part = parts.Next()) {
    if (part->name == "image" && !has_image) {
      TakePart(parts, "image", max_bytes, upload.image);
      has_image = true;
    } else if (part->name == "meta" && !has_meta) {
      TakePart(parts, "meta", kLimits.max_frame_meta_bytes, upload.meta);
      has_meta = true;
    } else {
      throw ApiError("UnknownPart", "a frame has one image and at most one meta part");
    }
  }
  if (!has_image) {
    throw ApiError("MissingPart", "the part image is missing", {{"/image", "is missing"}});
  }
  return upload;
}

// Also checks Repr-Digest, which may be of the whole body or of the image in it.
FrameUpload ReadUpload(const Service& service, const Call& call) {
  const size_t max_bytes = service.intake.image_limits.max_bytes;
  const auto boundary = MultipartBoundary(call.request.get_header_value("Content-Type"));
  const std::string digest = call.request.get_header_value("Repr-Digest");
  if (!boundary) {
    FrameUpload upload;
    upload.image = call.body.ReadAll(max_bytes);
    if (!digest.empty()) CheckDigest(digest, {Sha256Hex(upload.image)});
    if (upload.image.empty()) throw ApiError("MissingPart", "the body is empty: no image");
    return upload;
  }
  const std::string body =
      call.body.ReadAll(max_bytes + kLimits.max_frame_meta_bytes + kMultipartOverheadBytes);
  FrameUpload upload = ParseMultipart(body, *boundary, max_bytes);
  if (!digest.empty()) CheckDigest(digest, {Sha256Hex(body), Sha256Hex(upload.image)});
  return upload;
}

void TakeFrame(Service& service,
               const Call& call,
               const std::string& frame_id,
               httplib::Response& response) {
  if (!IsValidId(frame_id)) {
    throw ApiError("InvalidId", "a frame id must match [A-Za-z0-9._-]{1,128}");
  }
  const FlightRow flight = ExistingFlight(service, call);
  // A repeated request for a stored frame succeeds even if the queue is full.
  if (!service.storage.frames.Find(flight.id, frame_id)) RefuseWhenFull(service.intake);
  const Receiving receiving(service.intake, flight.id);
  const TakenFrame taken =
      TakeFrame(service.intake, flight.id, frame_id, ReadUpload(service, call));
  response.status = taken.is_new ? 201 : 200;
  response.set_header("Location", "/v1/flights/" + flight.id + "/frames");
  response.set_content(FrameJson(taken.frame).dump(), "application/json");
}

}  // namespace

void PutFrame(Service& service, const Call& call, httplib::Response& response) {
  TakeFrame(service, call, call.Id("frame"), response);
}

void PostFrame(Service& service, const Call& call, httplib::Response& response) {
  TakeFrame(service, call, NewId("frame"), response);
}

void GetFrames(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  nlohmann::json frames = nlohmann::json::array();
  for (const FrameRow& frame : service.storage.frames.List(flight.id)) {
    frames.push_back(FrameJson(frame));
  }
  response.set_content(nlohmann::json{{"frames", frames}}.dump(), "application/json");
}

}  // namespace freelsd
