// Private to export/. Legend of a layer's picture.
#pragma once

#include <string>

#include "api/export/layers/layers.h"

namespace freelsd {

// PNG with the layer's colours, the values of `scale` in the layer's unit, and a title. `name` is a
// layer of a site or of a flight's map.
std::string LegendPng(const std::string& name, const Scale& scale);

}  // namespace freelsd
