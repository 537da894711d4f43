#include "engine/mosaic/seams.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include <opencv2/imgproc/detail/gcgraph.hpp>

namespace freelsd {
namespace {

// Difference, grey levels, where two views cannot be compared.
constexpr int kUnknownDifference = 60;
constexpr int kBlack = 4;
constexpr int kWhite = 251;

class SeamCosts {
 public:
  SeamCosts(const std::vector<ViewLayer>& layers, const MosaicOptions& options)
      : layers_(layers),
        seam_cost_(static_cast<int>(std::lround(options.seam_cost))),
        exposure_cost_(static_cast<int>(std::lround(options.exposure_cost))) {}

  // The layer shows the cell.
  int OfView(int layer, const cv::Point& cell) const {
    const ViewLayer& shown = layers_[static_cast<size_t>(layer)];
    const cv::Point at = cell - shown.cells.tl();
    const cv::Vec3b& color = shown.picture(at);
    const int darkest = std::min({color[0], color[1], color[2]});
    const int brightest = std::max({color[0], color[1], color[2]});
    const bool is_badly_exposed = brightest < kBlack || darkest > kWhite;
    return shown.cost(at) + shown.blur_cost + (is_badly_exposed ? exposure_cost_ : 0);
  }

  // Of a seam between two neighbouring cells.
  int OfSeam(int a, int b, const cv::Point& p, const cv::Point& q) const {
    if (a == b) return 0;
    const int at_p = Difference(a, b, p), at_q = Difference(a, b, q);
    if (at_p < 0 && at_q < 0) return seam_cost_ + 2 * kUnknownDifference;
    if (at_p < 0) return seam_cost_ + 2 * at_q;
    if (at_q < 0) return seam_cost_ + 2 * at_p;
    return seam_cost_ + at_p + at_q;
  }

 private:
  // Grey levels; negative where one of the layers does not show the cell.
  int Difference(int a, int b, const cv::Point& cell) const {
    const ViewLayer& first = layers_[static_cast<size_t>(a)];
    const ViewLayer& second = layers_[static_cast<size_t>(b)];
    if (!first.Shows(cell) || !second.Shows(cell)) return -1;
    const cv::Vec3b& x = first.picture(cell - first.cells.tl());
    const cv::Vec3b& y = second.picture(cell - second.cells.tl());
    return (std::abs(x[0] - y[0]) + std::abs(x[1] - y[1]) + std::abs(x[2] - y[2])) / 3;
  }

  const std::vector<ViewLayer>& layers_;
  const int seam_cost_;
  const int exposure_cost_;
};

const cv::Point kNeighbours[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

// Offers one layer to every cell at once.
class Expansion {
 public:
  Expansion(const ViewLayer& layer,
            int number,
            const SeamCosts& costs,
            cv::Point first,
            cv::Mat1s& chosen)
      : layer_(layer),
        number_(number),
        costs_(costs),
        first_(first),
        chosen_(chosen),
        node_(layer.cost.size(), -1) {}

  // Returns whether a cell has changed.
  bool Run() {
    for (int row = 0; row < node_.rows; ++row) {
      for (int col = 0; col < node_.cols; ++col) {
        const cv::Point cell = layer_.cells.tl() + cv::Point(col, row);
        if (!layer_.is_candidate(row, col) || Chosen(cell) == number_) continue;
        node_(row, col) = static_cast<int>(cells_.size());
        cells_.push_back(cell);
      }
    }
    if (cells_.empty()) return false;
    keep_.assign(cells_.size(), 0);
    take_.assign(cells_.size(), 0);
    cv::detail::GCGraph<int> graph(static_cast<unsigned>(cells_.size()),
                                   static_cast<unsigned>(4 * cells_.size()));
    for (size_t i = 0; i < cells_.size(); ++i) graph.addVtx();
    for (size_t i = 0; i < cells_.size(); ++i) AddCell(i, graph);
    // Cells in the segment of the source keep their layers.
    for (size_t i = 0; i < cells_.size(); ++i) {
      const int common = std::min(keep_[i], take_[i]);
      graph.addTermWeights(static_cast<int>(i), take_[i] - common, keep_[i] - common);
    }
    // The library refuses a graph without edges.
    if (has_edges_) graph.maxFlow();
    bool has_changed = false;
    for (size_t i = 0; i < cells_.size(); ++i) {
      const bool keeps =
          has_edges_ ? graph.inSourceSegment(static_cast<int>(i)) : keep_[i] <= take_[i];
      if (keeps) continue;
      chosen_(cells_[i] - first_) = static_cast<int16_t>(number_);
      has_changed = true;
    }
    return has_changed;
  }

 private:
  int Chosen(const cv::Point& cell) const {
    const cv::Point at = cell - first_;
    if (!cv::Rect(cv::Point(), chosen_.size()).contains(at)) return -1;
    return chosen_(at);
  }

  int NodeAt(const cv::Point& cell) const {
    return layer_.cells.contains(cell) ? node_(cell - layer_.cells.tl()) : -1;
  }

  void AddCell(size_t i, cv::detail::GCGraph<int>& graph) {
    const cv::Point& cell = cells_[i];
    const int current = Chosen(cell);
    keep_[i] += costs_.OfView(current, cell);
    take_[i] += costs_.OfView(number_, cell);
    for (size_t n = 0; n < 4; ++n) {
      const cv::Point neighbour = cell + kNeighbours[n];
      const int other = Chosen(neighbour);
      if (other < 0) continue;
      const int node = NodeAt(neighbour);
      if (node < 0) {
        keep_[i] += costs_.OfSeam(current, other, cell, neighbour);
        take_[i] += costs_.OfSeam(number_, other, cell, neighbour);
      } else if (n < 2) {
        AddPair(i, static_cast<size_t>(node), graph);
      }
    }
  }

  // With x = 0 for keeping and 1 for taking, the seam costs a if both keep, b if only the first
  // keeps, c if only the second keeps, and nothing if both take. This is a + (c - a) x_p - c x_q +
  // (b + c - a) (1 - x_p) x_q.
  void AddPair(size_t i, size_t j, cv::detail::GCGraph<int>& graph) {
    const cv::Point& p = cells_[i];
    const cv::Point& q = cells_[j];
    const int b = costs_.OfSeam(Chosen(p), number_, p, q);
    const int c = costs_.OfSeam(number_, Chosen(q), p, q);
    // It is larger only where views cannot be compared. No graph could express that.
    const int a = std::min(costs_.OfSeam(Chosen(p), Chosen(q), p, q), b + c);
    take_[i] += c - a;
    take_[j] -= c;
    graph.addEdges(static_cast<int>(i), static_cast<int>(j), b + c - a, 0);
    has_edges_ = true;
  }

  const ViewLayer& layer_;
  const int number_;
  const SeamCosts& costs_;
  const cv::Point first_;
  cv::Mat1s& chosen_;
  cv::Mat1i node_;
  std::vector<cv::Point> cells_;
  std::vector<int> keep_, take_;
  bool has_edges_ = false;
};

cv::Mat1s CheapestLayers(const std::vector<ViewLayer>& layers,
                         const SeamCosts& costs,
                         const LatticeRect& seam_cells) {
  cv::Mat1s chosen(seam_cells.cells.size(), int16_t{-1});
  cv::Mat1i least(seam_cells.cells.size(), std::numeric_limits<int>::max());
  for (size_t i = 0; i < layers.size(); ++i) {
    const cv::Rect& cells = layers[i].cells;
    for (int row = cells.y; row < cells.br().y; ++row) {
      for (int col = cells.x; col < cells.br().x; ++col) {
        if (!layers[i].Offers({col, row})) continue;
        const int cost = costs.OfView(static_cast<int>(i), {col, row});
        const cv::Point at = cv::Point(col, row) - seam_cells.cells.tl();
        if (cost >= least(at)) continue;
        least(at) = cost;
        chosen(at) = static_cast<int16_t>(i);
      }
    }
  }
  return chosen;
}

}  // namespace

cv::Mat1s ChooseLayers(const std::vector<ViewLayer>& layers,
                       const LatticeRect& seam_cells,
                       const MosaicOptions& options) {
  const SeamCosts costs(layers, options);
  cv::Mat1s chosen = CheapestLayers(layers, costs, seam_cells);
  for (int round = 0; round < options.max_num_rounds; ++round) {
    bool has_changed = false;
    for (size_t i = 0; i < layers.size(); ++i) {
      Expansion expansion(layers[i], static_cast<int>(i), costs, seam_cells.cells.tl(), chosen);
      has_changed = expansion.Run() || has_changed;
    }
    if (!has_changed) break;
  }
  return chosen;
}

double MeanStep(const std::vector<ViewLayer>& layers,
                const cv::Mat1s& chosen,
                const LatticeRect& seam_cells,
                const std::function<cv::Vec3d(size_t layer, const cv::Point& cell)>& color_of) {
  // Length of each seam, and the sum of its differences.
  std::map<std::pair<size_t, size_t>, std::pair<int, double>> seams;
  const auto measure = [&](const cv::Point& at, const cv::Point& next) {
    if (next.x >= chosen.cols || next.y >= chosen.rows) return;
    const int first = std::min(chosen(at), chosen(next));
    const int second = std::max(chosen(at), chosen(next));
    if (first < 0 || first == second) return;
    const auto a = static_cast<size_t>(first), b = static_cast<size_t>(second);
    const cv::Point cell = at + seam_cells.cells.tl();
    if (!layers[a].Shows(cell) || !layers[b].Shows(cell)) return;
    auto& [length, difference] = seams[{a, b}];
    ++length;
    const cv::Vec3d step = color_of(a, cell) - color_of(b, cell);
    difference += (step[0] + step[1] + step[2]) / 3.0;
  };
  for (int row = 0; row < chosen.rows; ++row) {
    for (int col = 0; col < chosen.cols; ++col) {
      measure({col, row}, {col + 1, row});
      measure({col, row}, {col, row + 1});
    }
  }
  double sum = 0.0;
  int total_length = 0;
  for (const auto& [pair, seam] : seams) {
    sum += std::abs(seam.second);
    total_length += seam.first;
  }
  return total_length == 0 ? 0.0 : sum / total_length;
}

}  // namespace freelsd
