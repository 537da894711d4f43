// Cells of ground whose kind is known, with their cues; and the files that keep them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/cover/kind/cues.h"

namespace freelsd {

struct KindCell {
  // Name of the cover, or of what was outlined.
  std::string kind;
  // 1: grass fit to land on; 0: anything else; NaN: only reported.
  float is_fit = 0.0f;
  // Number of cells that it stands for.
  float weight = 1.0f;
  // NaN where unknown.
  std::array<float, kNumCues> cues{};
};

struct KindCells {
  // What is left out together: a look of worlds, or a place.
  std::string group;
  std::string name;
  std::vector<KindCell> cells;
};

// Rasters of a map, before cells are drawn from them.
struct KindRasters {
  // Index into `kinds` + 1; 0 where nothing is known.
  cv::Mat1b kind;
  std::vector<std::string> kinds;
  // Of `kinds`; as KindCell::is_fit.
  std::vector<float> is_fit;
  std::array<cv::Mat1f, kNumCues> cues;
};

// At most `max_num_cells` of every kind, evenly spread. The same rasters give the same cells.
std::vector<KindCell> DrawCells(const KindRasters& rasters, size_t max_num_cells);

void WriteCells(const std::string& path, const KindCells& cells);
// Throws std::runtime_error when the file has other cues.
KindCells ReadCells(const std::string& path);

}  // namespace freelsd
