#include "engine/mosaic/seams.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

ViewLayer OneCell(uint8_t cost) {
  ViewLayer layer;
  layer.cells = {3, 4, 1, 1};
  layer.cost = cv::Mat1b(1, 1, cost);
  layer.is_candidate = cv::Mat1b(1, 1, uchar{255});
  layer.picture = cv::Mat3b(1, 1, cv::Vec3b(100, 100, 100));
  layer.detail = cv::Mat1b(1, 1, uchar{8});
  return layer;
}

TEST_CASE("seams: a cell without neighbours has its cheapest view") {
  LatticeRect seam_cells;
  seam_cells.cells = {2, 3, 3, 3};
  for (const bool is_first_cheaper : {true, false}) {
    const std::vector<ViewLayer> layers{OneCell(is_first_cheaper ? 5 : 50),
                                        OneCell(is_first_cheaper ? 50 : 5)};
    const cv::Mat1s chosen = ChooseLayers(layers, seam_cells, {});
    CHECK(chosen(1, 1) == (is_first_cheaper ? 0 : 1));
    CHECK(chosen(0, 0) == -1);
  }
}

}  // namespace
}  // namespace freelsd
