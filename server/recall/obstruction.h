// What obstacles make of a stored plan.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

// The broken rule, as reject_reason, a sentence with numbers, and the obstacles that break it.
struct Obstruction {
  std::string reason;
  std::string detail;
  std::vector<std::string> obstacle_ids;
};

}  // namespace freelsd
