#include "engine/approach/corridor.h"

#include <cmath>

#include "engine/geometry/geometry.h"

namespace freelsd {

Corridor MakeCorridor(double heading, double half_width, double cell_size) {
  const Eigen::Vector2d forward = DirectionOf(heading);
  const double reach = half_width + cell_size * std::sqrt(0.5);
  Corridor corridor;
  corridor.across = {forward.y(), -forward.x()};
  corridor.num_each_side = static_cast<int>(std::ceil(reach / (kAcrossSpacing * cell_size)));
  corridor.spacing = reach / corridor.num_each_side;
  return corridor;
}

std::vector<double> Steps(double from, double to, double step) {
  std::vector<double> distances;
  const int num_whole = static_cast<int>(std::floor((to - from) / step));
  for (int i = 0; i <= num_whole; ++i) distances.push_back(from + i * step);
  if (!distances.empty() && distances.back() < to) distances.push_back(to);
  return distances;
}

}  // namespace freelsd
