// Input: a world and an aircraft. Output: what is wrong with every cell of ground, and the fields
// on which that aircraft could truly land. Computed from the world alone.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "tests/synthetic/truth.h"

namespace freelsd {

// Rasters of 1 m cells over the world: row 0 south, column 0 west.
struct TruthMap {
  double size_m = 0.0;
  double cell_size_m = 1.0;
  cv::Mat1b fault;  // GroundFault
  // Highest cover within the cell that is not meadow; kMeadow if the cell has only meadow.
  cv::Mat1b cover;
  // Height of the highest object within the cell, world z.
  cv::Mat1f top;
  // Metres to the nearest cell that is not landable.
  cv::Mat1f free_distance;

  Eigen::Vector2d CellCenter(int row, int col) const;
  // x = column, y = row; clamped to the world.
  cv::Point CellAt(const Eigen::Vector2d& place) const;
};

TruthMap MakeTruthMap(const World& world, const Aircraft& aircraft);

// Ground that one sees from above and on which nothing grows high.
bool IsOpenGround(Cover cover);

// One connected piece of ground on which the touchdown disc fits, of at least the aircraft's least
// area. Parcels do not matter: two meadows without a border are one field.
struct Field {
  int id = 0;
  double area_m2 = 0.0;
  // Some touchdown of it has disc, ground roll and final free in the world's wind.
  bool is_landable = false;
  // The roomiest such touchdown; for a field that is not landable the roomiest disc.
  Eigen::Vector2d touchdown = Eigen::Vector2d::Zero();
  double free_radius = 0.0;
  // Number of places on which one could touch down, of a lattice of 3 m.
  int num_touchdowns = 0;
  // The same, where touchdown, roll and final are also all within the ground that was seen.
  int num_seen_touchdowns = 0;
  // A loiter circle at the final of `touchdown` is clear on some side.
  bool has_loiter = false;
};

struct Fields {
  std::vector<Field> fields;
  // Field of every cell of the truth map: index + 1, 0 where none.
  cv::Mat1i label;
};

// `seen`: cells of the truth map that the flight saw; 255 or 0.
Fields FindFields(const World& world,
                  const TruthMap& truth,
                  const Aircraft& aircraft,
                  const cv::Mat1b& seen);

}  // namespace freelsd
