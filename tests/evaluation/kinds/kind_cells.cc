#include "tests/evaluation/kinds/kind_cells.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace freelsd {
namespace {

std::string HeaderOf(const KindCells& cells) {
  std::string header = "group,name,kind,is_fit,weight";
  for (const char* name : kCueNames) header += std::string(",") + name;
  return header + "\n" + cells.group + "," + cells.name;
}

float NumberOf(const std::string& text) {
  return text == "nan" ? std::numeric_limits<float>::quiet_NaN() : std::stof(text);
}

}  // namespace

std::vector<KindCell> DrawCells(const KindRasters& rasters, size_t max_num_cells) {
  std::vector<std::vector<cv::Point>> places(rasters.kinds.size());
  for (int row = 0; row < rasters.kind.rows; ++row) {
    for (int col = 0; col < rasters.kind.cols; ++col) {
      const size_t kind = rasters.kind(row, col);
      if (kind > 0) places[kind - 1].emplace_back(col, row);
    }
  }
  std::vector<KindCell> cells;
  for (size_t kind = 0; kind < places.size(); ++kind) {
    const size_t num = std::min(max_num_cells, places[kind].size());
    for (size_t i = 0; i < num; ++i) {
      const cv::Point place = places[kind][i * places[kind].size() / num];
      KindCell cell{rasters.kinds[kind],
                    rasters.is_fit[kind],
                    static_cast<float>(places[kind].size()) / static_cast<float>(num),
                    {}};
      for (size_t cue = 0; cue < kNumCues; ++cue) {
        const cv::Mat1f& raster = rasters.cues[cue];
        cell.cues[cue] = raster.empty() ? std::numeric_limits<float>::quiet_NaN() : raster(place);
      }
      cells.push_back(std::move(cell));
    }
  }
  return cells;
}

void WriteCells(const std::string& path, const KindCells& cells) {
  std::ofstream file(path);
  file << HeaderOf(cells) << "\n";
  file.precision(6);
  for (const KindCell& cell : cells.cells) {
    file << cell.kind << "," << cell.is_fit << "," << cell.weight;
    for (const float value : cell.cues) file << "," << value;
    file << "\n";
  }
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

KindCells ReadCells(const std::string& path) {
  std::ifstream file(path);
  KindCells cells;
  std::string header, line, part;
  std::getline(file, header);
  std::getline(file, line);
  std::istringstream names(line);
  std::getline(names, cells.group, ',');
  std::getline(names, cells.name);
  if (header + "\n" + line != HeaderOf(cells)) {
    throw std::runtime_error(path + " is not a file of cells with these cues");
  }
  while (std::getline(file, line)) {
    std::istringstream parts(line);
    KindCell cell;
    std::getline(parts, cell.kind, ',');
    std::getline(parts, part, ',');
    cell.is_fit = NumberOf(part);
    std::getline(parts, part, ',');
    cell.weight = NumberOf(part);
    for (float& value : cell.cues) {
      std::getline(parts, part, ',');
      value = NumberOf(part == "-nan" ? "nan" : part);
    }
    cells.cells.push_back(std::move(cell));
  }
  return cells;
}

}  // namespace freelsd
