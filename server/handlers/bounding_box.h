// Parses the query parameter bbox.
#pragma once

#include <optional>

#include "server/http/http.h"
#include "storage/storage.h"

namespace freelsd {

// "west,south,east,north" in degrees; west > east crosses the antimeridian. Nothing if the
// parameter is absent. Throws ApiError InvalidQuery.
std::optional<BoundingBox> ParseBoundingBox(const Call& call);

}  // namespace freelsd
