// Private to heights/. From measures to likelihoods.
#pragma once

#include "engine/heights/heights.h"

namespace freelsd {

// Completes heights whose evidence is measured.
void Judge(const HeightsOptions& options, PhotographHeights& heights);

}  // namespace freelsd
