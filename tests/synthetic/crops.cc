#include "tests/synthetic/crops.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace freelsd {
namespace {

// Booms of sprayers.
constexpr std::array<double, 6> kWorkingWidthsM{12.0, 18.0, 24.0, 24.0, 27.0, 36.0};
// Between the middles of a tractor's two wheels, and what a wheel leaves.
constexpr double kTrackGaugeM = 1.9;
constexpr double kTrackWidthM = 0.45;
constexpr double kMaizeRowM = 0.75;
// Beyond that height the leaves of neighbouring rows meet.
constexpr double kClosedMaizeM = 0.9;
constexpr double kMinHeightM = 0.3;
constexpr double kMaxCerealM = 1.0;
constexpr double kMaxMaizeM = 1.6;

bool IsOnTracks(double from_middle) {
  return std::abs(std::abs(from_middle) - 0.5 * kTrackGaugeM) <= 0.5 * kTrackWidthM;
}

}  // namespace

CropStand CropOf(uint8_t variant) {
  const int kind = variant % 4;
  const int step = variant / 4;
  const double growth = step / 63.0;
  CropStand crop;
  crop.is_maize = kind == 3;
  crop.height_m = kMinHeightM + growth * ((crop.is_maize ? kMaxMaizeM : kMaxCerealM) - kMinHeightM);
  if (!crop.is_maize) crop.tramline_spacing_m = kWorkingWidthsM[variant / 4 % 6];
  return crop;
}

bool IsBare(const CropStand& crop, const Eigen::Vector2d& place, const Eigen::Vector2d& size) {
  const int along = size.x() >= size.y() ? 0 : 1;
  const double across = place[1 - along];
  if (crop.is_maize) {
    const double share_of_soil = 0.55 * (1.0 - crop.height_m / kClosedMaizeM);
    const double phase = across / kMaizeRowM - std::floor(across / kMaizeRowM);
    return phase < share_of_soil;
  }
  if (crop.tramline_spacing_m <= 0.0) return false;
  const double half = 0.5 * crop.tramline_spacing_m;
  const double to_border = std::min(place.minCoeff(), (size - place).minCoeff());
  if (IsOnTracks(to_border - half)) return true;
  const double pass = std::floor(across / crop.tramline_spacing_m);
  // The rows end where the round begins.
  return to_border > half && IsOnTracks(across - pass * crop.tramline_spacing_m - half);
}

}  // namespace freelsd
