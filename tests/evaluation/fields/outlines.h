// Input: a text with outlines that people drew on photographs. Output: those outlines.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/geometry/geometry.h"

namespace freelsd {

enum class OutlineKind {
  // Ground. A careful pilot would land on it, would not, or nobody can tell.
  kLand,
  kRefuse,
  kDoubt,
  // Things.
  kWall,
  kFence,
  kStream,
  kTree,
  kHedge,
  kRoad,
  kPerson,
  kVehicle,
  kBuilding,
  kPole,
  kBoulder,
};
constexpr int kNumOutlineKinds = 14;
const char* NameOf(OutlineKind kind);
bool IsGround(OutlineKind kind);
// Thinner than a few pixels of an aerial photograph: scored in a column of its own.
bool IsThin(OutlineKind kind);

// What one photograph shows of a piece of ground or of a thing. Several outlines with the same id
// are views of the same object.
struct Outline {
  std::string id;
  OutlineKind kind = OutlineKind::kDoubt;
  // Name of the file without its extension.
  std::string photograph;
  // Of a thing, above the ground.
  double height_m = 0.0;
  // Pixels of the stored photograph: x = column, y = row. EXIF orientation is ignored. Two corners
  // are a line.
  Polygon corners_in_image;
};

// A line is "ID KIND PHOTOGRAPH HEIGHT_M col row col row ...", where '#' begins a comment. Throws
// std::runtime_error, which begins with "NAME:LINE: ", on bad lines and if an id has two kinds.
std::vector<Outline> ParseOutlines(std::string_view text, const std::string& name);

}  // namespace freelsd
