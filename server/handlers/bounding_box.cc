#include "server/handlers/bounding_box.h"

#include "server/following/following.h"

namespace freelsd {

std::optional<BoundingBox> ParseBoundingBox(const Call& call) {
  const std::optional<std::string> text = call.Query("bbox");
  if (!text) return std::nullopt;
  return ParseArea(*text);
}

}  // namespace freelsd
