// Pictures that show what the watch saw.
#pragma once

#include <string>

#include "engine/watch/watch.h"

namespace freelsd {

// Stored picture, registered photograph, and the change in deviations: of colour green, of
// brightness red. PNG.
void WriteComparison(const StripPicture& strip,
                     const WatchedPhoto& photo,
                     const WatchOptions& options,
                     const std::string& file);

}  // namespace freelsd
