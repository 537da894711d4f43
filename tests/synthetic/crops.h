// Private to the countryside: how a field of standing green crop is sown and driven on.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace freelsd {

struct CropStand {
  // In rows far enough apart to see the soil between them while it is young; the others close.
  bool is_maize = false;
  double height_m = 0.0;
  // Distance of the sprayer's tracks, which is its working width; 0: has none.
  double tramline_spacing_m = 0.0;
};

// Every field of a kind has its own height and working width: 0.3 to 1 m, maize to 1.6 m.
CropStand CropOf(uint8_t variant);

// Does the soil show at that place of a field of that size? Of two wheel tracks every working
// width along the longer side, of the round around the field at half of it, and between the rows
// of young maize. `place` counts from the field's corner.
bool IsBare(const CropStand& crop, const Eigen::Vector2d& place, const Eigen::Vector2d& size);

}  // namespace freelsd
