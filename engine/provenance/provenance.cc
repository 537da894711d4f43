#include "engine/provenance/provenance.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "engine/check/check.h"

namespace freelsd {
namespace {

// A photograph that shows less than this of the surroundings may be missed.
constexpr double kSpacingM = 5.0;

std::optional<Eigen::Vector2d> PixelIn(const AdjustedBlock& block,
                                       size_t view,
                                       const Eigen::Vector3d& place_in_world) {
  const Camera camera = block.CameraOf(view);
  const auto pixel =
      camera.ImageFromCamera(Inverse(block.views[view].world_from_camera) * place_in_world);
  return pixel && camera.IsInside(*pixel) ? pixel : std::nullopt;
}

bool ShowsSome(const AdjustedBlock& block,
               size_t view,
               const std::vector<Eigen::Vector3d>& places_in_world) {
  return std::any_of(places_in_world.begin(), places_in_world.end(), [&](const auto& place) {
    return PixelIn(block, view, place).has_value();
  });
}

// A disc, the outer places first: a photograph that shows its middle shows its rim, too, or is
// small.
std::vector<Eigen::Vector3d> DiscAround(const Eigen::Vector3d& place_in_world, double radius_m) {
  std::vector<Eigen::Vector3d> disc{place_in_world};
  const int steps = static_cast<int>(radius_m / kSpacingM) + 1;
  for (int row = -steps; row <= steps; ++row) {
    for (int col = -steps; col <= steps; ++col) {
      const Eigen::Vector3d offset(col * kSpacingM, row * kSpacingM, 0.0);
      if (offset.norm() <= radius_m + kSpacingM) disc.push_back(place_in_world + offset);
    }
  }
  return disc;
}

// Inverse variance of the height that a pair gives, up to a common factor.
double InformationOf(const StereoPair& pair,
                     const AdjustedBlock& block,
                     const Eigen::Vector3d& place_in_world) {
  const Eigen::Vector3d& left = block.views[pair.left].world_from_camera.translation;
  const Eigen::Vector3d& right = block.views[pair.right].world_from_camera.translation;
  const double height = std::max(1.0, 0.5 * (left.z() + right.z()) - place_in_world.z());
  const double baseline_ratio = (left - right).head<2>().norm() / height;
  return baseline_ratio * baseline_ratio / (height * height);
}

}  // namespace

void ProvenanceOptions::Check() const {
  const FieldCheck check("provenance");
  check.Inside("context_m", context_m, 0.0, 1000.0);
  check.Inside("beyond_hazard_m", beyond_hazard_m, 0.0, 1000.0);
}

double ProvenanceOptions::ContextFor(double hazard_distance_m) const {
  return std::max(context_m, hazard_distance_m + beyond_hazard_m);
}

Provenance ProvenanceOf(const Eigen::Vector3d& place_in_world,
                        const AdjustedBlock& block,
                        const std::vector<StereoPair>& pairs,
                        double hazard_distance_m,
                        const ProvenanceOptions& options) {
  options.Check();
  std::map<size_t, SourceView> sources;
  std::set<size_t> around;
  const std::vector<Eigen::Vector3d> disc =
      DiscAround(place_in_world, options.ContextFor(hazard_distance_m));
  for (size_t view = 0; view < block.views.size(); ++view) {
    if (!block.views[view].is_connected) continue;
    if (const auto pixel = PixelIn(block, view, place_in_world))
      sources[view] = {view, *pixel, 0.0};
    if (sources.contains(view) || ShowsSome(block, view, disc)) around.insert(view);
  }
  std::set<size_t> used = around;
  double sum = 0.0;
  for (const StereoPair& pair : pairs) {
    if (around.contains(pair.left)) used.insert(pair.right);
    if (around.contains(pair.right)) used.insert(pair.left);
    if (!sources.contains(pair.left) || !sources.contains(pair.right)) continue;
    const double information = InformationOf(pair, block, place_in_world);
    for (const size_t view : {pair.left, pair.right}) sources[view].weight += information;
    sum += 2.0 * information;
  }
  Provenance provenance;
  for (const auto& [view, source] : sources) {
    provenance.sources.push_back(source);
    if (sum > 0.0) provenance.sources.back().weight /= sum;
    used.erase(view);
  }
  std::stable_sort(provenance.sources.begin(),
                   provenance.sources.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  provenance.context.assign(used.begin(), used.end());
  return provenance;
}

}  // namespace freelsd
