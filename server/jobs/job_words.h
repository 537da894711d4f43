// Plain English for jobs.
#pragma once

#include <string>

namespace freelsd {

// "Comparing pairs of photographs" for "stereo". A stage without a title is its own title.
std::string StageTitle(const std::string& stage);
// "about 25 s", "about 3 min", "about 2 h"; "a few seconds" if less are left.
std::string AboutTime(double seconds);

}  // namespace freelsd
