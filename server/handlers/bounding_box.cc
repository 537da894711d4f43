#include "server/handlers/bounding_box.h"

#include <cmath>
#include <vector>

#include "api/api.h"

namespace freelsd {
namespace {

BoundingBox ParseBox(const std::string& text) {
  const std::vector<double> sides = ParseQueryNumbers(text, "bbox");
  const bool is_box = sides.size() == 4 && std::abs(sides[0]) <= 180 && std::abs(sides[2]) <= 180 &&
                      sides[1] >= -90 && sides[1] <= sides[3] && sides[3] <= 90;
  if (!is_box) {
    const std::string detail = "bbox: must be west,south,east,north in degrees";
    throw ApiError("InvalidQuery", detail, {{"bbox", detail}});
  }
  return {sides[0], sides[1], sides[2], sides[3]};
}

}  // namespace

std::optional<BoundingBox> ParseBoundingBox(const Call& call) {
  const std::optional<std::string> text = call.Query("bbox");
  if (!text) return std::nullopt;
  return ParseBox(*text);
}

}  // namespace freelsd
