// A simulated aircraft that flies along a told path, for tests of paths.
#pragma once

#include <vector>

#include "engine/glide/glide.h"
#include "engine/glide/performance.h"

namespace freelsd {

// A point mass that steers towards a point of the path ahead of it, with limited bank.
class PointMass {
 public:
  // `points` of the path, in world. `arrival`: index of the point from which on it flies at landing
  // speed. An unknown wind counts as calm, an unknown heading as north. `points` must outlive it.
  PointMass(const std::vector<DescentPoint>& points,
            size_t arrival,
            const GlideStart& start,
            const Aircraft& aircraft);

  // Flies until the point `end` is abeam. Returns the height there.
  double FlyTo(size_t end);
  // Flies on for a short time. False at the end of the path.
  bool Step();

  // Index of the point that the aircraft has passed last.
  size_t segment() const { return segment_; }
  const Eigen::Vector3d& position_in_world() const { return position_; }
  double max_track_error_m() const { return max_track_error_; }

 private:
  Eigen::Vector2d PlaceOf(size_t i) const { return points_[i].position_in_world.head<2>(); }
  // Moves on to the segment beside the aircraft. Returns the point ahead on the path.
  Eigen::Vector2d Ahead();
  Eigen::Vector2d PointFrom(size_t i, double length) const;

  const std::vector<DescentPoint>& points_;
  size_t arrival_;
  Performance gliding_;
  Performance landing_;
  Eigen::Vector2d wind_;
  Eigen::Vector3d position_;
  double heading_ = 0.0;
  double max_lateral_;
  size_t segment_ = 0;
  double time_ = 0.0;
  double max_track_error_ = 0.0;
};

}  // namespace freelsd
