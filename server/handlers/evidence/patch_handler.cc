// A part of a stored photograph.
#include <algorithm>
#include <cmath>

#include "api/api.h"
#include "api/export/map/map.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/intake/intake.h"

namespace freelsd {
namespace {

constexpr double kMaxSidePx = 512.0;

double NeededPixels(const Call& call, const std::string& name, double least, double most) {
  const std::optional<double> value = call.QueryNumber(name);
  if (!value) throw ApiError("InvalidQuery", name + ": is missing", {{name, "is missing"}});
  if (*value >= least && *value <= most) return *value;
  const std::string detail = "must be in [" + std::to_string(std::lround(least)) + ", " +
                             std::to_string(std::lround(most)) + "]";
  throw ApiError("InvalidValue", name + ": " + detail, {{name, detail}});
}

}  // namespace

void GetFramePatch(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  constexpr double kMaxPx = 100000.0;
  const double x_px = NeededPixels(call, "x_px", 0.0, kMaxPx);
  const double y_px = NeededPixels(call, "y_px", 0.0, kMaxPx);
  const auto side_px = static_cast<int>(NeededPixels(call, "side_px", 1.0, kMaxSidePx));
  const LongPlace place(service.long_queues.plans, WantedBy(service, call));
  const cv::Mat image = [&] {
    const SemaphoreSlot slot(service.intake.decoders);
    return StoredImages(service.intake, flight.id)(call.Id("frame"));
  }();
  if (image.empty()) throw ApiError("NoSuchFrame", "the flight has no photograph of this frame");
  const cv::Rect wanted(static_cast<int>(std::lround(x_px)) - side_px / 2,
                        static_cast<int>(std::lround(y_px)) - side_px / 2,
                        side_px,
                        side_px);
  if ((wanted & cv::Rect({0, 0}, image.size())).empty()) {
    throw ApiError("InvalidValue",
                   "x_px, y_px: outside the photograph",
                   {{"x_px", "outside the photograph"}, {"y_px", "outside the photograph"}});
  }
  response.set_header("Cache-Control", "private, max-age=3600");
  response.set_content(PatchPng(image, wanted), "image/png");
}

}  // namespace freelsd
