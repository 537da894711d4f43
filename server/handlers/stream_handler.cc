#include <chrono>
#include <thread>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/http/http.h"
#include "server/intake/intake.h"

namespace freelsd {
namespace {

// How often a full queue is checked again. Meanwhile the full socket slows the client down.
constexpr std::chrono::milliseconds kQueuePeriod{50};

enum class PartKind { kImage, kMeta };

PartKind KindOf(const Part& part) {
  if (part.name == "image" || part.content_type.starts_with("image/")) return PartKind::kImage;
  if (part.name == "meta" || part.content_type.starts_with("application/json")) {
    return PartKind::kMeta;
  }
  throw ApiError("UnknownPart", "a stream has image parts, each after an optional meta part");
}

// Without a meta part, the image part's X-Timestamp-Us gives the timestamp.
std::string MetaFromHeader(const Part& part) {
  if (part.timestamp_us.empty()) return "{}";
  return "{\"timestamp_us\":" + part.timestamp_us + "}";
}

class FrameStream {
 public:
  FrameStream(Intake& intake, const std::string& flight_id)
      : intake_(intake), flight_id_(flight_id) {}

  // Stores each part before it reads the next.
  void Read(MultipartReader& parts) {
    std::optional<std::string> meta;
    while (const std::optional<Part> part = parts.Next()) {
      if (KindOf(*part) == PartKind::kMeta) {
        meta = parts.ReadAll(kLimits.max_frame_meta_bytes).value_or("");
        continue;
      }
      const auto image = parts.ReadAll(intake_.image_limits.max_bytes);
      TakeImage(*part, image, meta.value_or(MetaFromHeader(*part)));
      meta.reset();
    }
  }
  nlohmann::json Answer() const {
    nlohmann::json answer{{"accepted", num_accepted_}, {"rejected", rejected_}};
    if (num_rejected_ > rejected_.size()) answer["num_rejected"] = num_rejected_;
    return answer;
  }

 private:
  // A refused image does not end the stream.
  void TakeImage(const Part& part,
                 const std::optional<std::string>& image,
                 const std::string& meta) {
    std::string frame_id = IdFromFileName(part.file_name);
    if (!IsValidId(frame_id)) frame_id = NewId("frame");
    try {
      if (!image) throw ApiError("ImageTooLarge", "the image is too large");
      TakeWhenThereIsRoom(frame_id, {*image, meta});
      ++num_accepted_;
    } catch (const ApiError& error) {
      if (error.code() == "ShuttingDown" || error.code() == "NoSuchFlight") throw;
      Reject(frame_id, error);
    }
  }
  void TakeWhenThereIsRoom(const std::string& frame_id, const FrameUpload& upload) {
    while (true) {
      if (intake_.is_stopping) throw ApiError("ShuttingDown", "the server is stopping");
      try {
        TakeFrame(intake_, flight_id_, frame_id, upload);
        return;
      } catch (const ApiError& error) {
        if (error.code() != "QueueFull") throw;
      }
      while (!intake_.is_stopping &&
             intake_.storage.frames.CountQueued() >= intake_.config.max_num_queued_frames) {
        std::this_thread::sleep_for(kQueuePeriod);
      }
    }
  }
  void Reject(const std::string& frame_id, const ApiError& error) {
    ++num_rejected_;
    intake_.storage.flights.Change(flight_id_,
                                   [](FlightRow& flight) { ++flight.num_rejected_frames; });
    const nlohmann::json rejection{
        {"id", frame_id}, {"code", error.code()}, {"detail", error.what()}};
    intake_.events.Publish(
        "frame",
        flight_id_,
        nlohmann::json{{"id", frame_id}, {"state", "rejected"}, {"reason", error.what()}}.dump());
    if (rejected_.size() < kLimits.answer.max_num_listed_rejections) rejected_.push_back(rejection);
  }

  Intake& intake_;
  std::string flight_id_;
  int64_t num_accepted_ = 0;
  size_t num_rejected_ = 0;
  nlohmann::json rejected_ = nlohmann::json::array();
};

}  // namespace

void PostStream(Service& service, const Call& call, httplib::Response& response) {
  const std::string flight_id = ExistingFlight(service, call).id;
  const std::string type = call.request.get_header_value("Content-Type");
  auto boundary = MultipartBoundary(type, "multipart/mixed");
  if (!boundary) boundary = MultipartBoundary(type);
  if (!boundary) {
    throw ApiError("UnsupportedMediaType", "a stream must be multipart/mixed");
  }
  const Streaming streaming(service.intake, flight_id);
  call.body.LimitTo(kLimits.stream.max_frame_stream_bytes);
  call.body.WaitFor(std::chrono::seconds(kLimits.stream.max_pause_s));
  MultipartReader parts([&call](char* bytes, size_t size) { return call.body.Read(bytes, size); },
                        *boundary);
  FrameStream stream(service.intake, flight_id);
  stream.Read(parts);
  response.set_content(stream.Answer().dump(), "application/json");
}

}  // namespace freelsd
