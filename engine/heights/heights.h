// Input: a map's heights, the adjusted views and their images. Output: how well each height of one
// place explains the photographs that show it.
//
// Plane sweep in object space (vertical line locus; Collins 1996): small patches of ground that
// follow the map's slope are lifted to one height after another, and every view that sees them is
// resampled onto them. At the right height all views show the same.
#pragma once

#include <optional>
#include <vector>

#include "engine/terrain/terrain.h"

namespace freelsd {

// The evidence behind the height of a cell of the map.
struct HeightLikelihood {
  // World z, ascending, evenly spaced.
  std::vector<double> heights;
  // Natural logarithm, 0 at the best height: the views' differences are normal, of unknown
  // variance.
  std::vector<double> log_likelihood;
  int num_views = 0;
  // Widest baseline over height among them.
  double baseline_ratio = 0.0;
  // Of the views at the best height, at most 1.
  double correlation = 0.0;
};

// `map`: seen cells around the place, which lies on its grid; 2 m below and above their heights are
// searched. Only connected views are used. A frame whose image is empty, or has another size than
// the camera, is skipped. Nothing if the place is unseen, or if fewer than two photographs with an
// image show it.
std::optional<HeightLikelihood> HeightLikelihoodAt(const Eigen::Vector2d& place_in_world,
                                                   const ElevationMap& map,
                                                   const AdjustedBlock& block,
                                                   const ImageSource& images);

}  // namespace freelsd
