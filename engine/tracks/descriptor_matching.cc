#include "engine/tracks/descriptor_matching.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Lowe's ratio of the nearest to the second nearest distance.
constexpr double kMaxDistanceRatio = 0.85;
// Approximate cosine between root descriptors of unrelated points.
constexpr float kUnrelatedCosine = 0.75F;
constexpr int kNumEntries = 128;
// Rows compared at once, and columns searched side by side.
constexpr int kNumRowsTogether = 4;
constexpr int kNumLanes = 16;

int RoundedUp(int count, int multiple) { return (count + multiple - 1) / multiple * multiple; }

// Descriptors as 16-bit integers, whose products sum exactly, and factors that turn sums into
// cosines. Padded with rows of zeros.
struct WideRows {
  int num_rows = 0;
  std::vector<int16_t> entries;
  std::vector<float> inverse_norm;

  const int16_t* Row(int row) const { return entries.data() + kNumEntries * row; }
};

WideRows WideRowsOf(const cv::Mat& bytes) {
  WideRows wide;
  wide.num_rows = bytes.rows;
  const auto num_padded = static_cast<size_t>(RoundedUp(bytes.rows, kNumLanes));
  wide.entries.assign(num_padded * kNumEntries, 0);
  wide.inverse_norm.assign(num_padded, 0.0F);
  for (int row = 0; row < bytes.rows; ++row) {
    const uchar* from = bytes.ptr<uchar>(row);
    std::copy(from, from + kNumEntries, wide.entries.begin() + kNumEntries * row);
    int64_t squares = 0;
    for (int i = 0; i < kNumEntries; ++i) squares += from[i] * from[i];
    wide.inverse_norm[static_cast<size_t>(row)] =
        static_cast<float>(1.0 / std::max(std::sqrt(static_cast<double>(squares)), 1.0));
  }
  return wide;
}

// Cosines are not negative. Non-negative floats sort like their bits, and every instruction set has
// a maximum of integers.
float CosineOf(int32_t bits) { return std::bit_cast<float>(bits); }

// Cosines of one row with every row of the other set.
FREELSD_SEVERAL_TARGETS void Cosines(const int16_t* row,
                                     float inverse_norm,
                                     const int16_t* others,
                                     const float* inverse_norms,
                                     int num_others,
                                     int32_t* bits) {
  for (int j = 0; j < num_others; j += kNumRowsTogether) {
    const int16_t* other = others + kNumEntries * j;
    int32_t sum_0 = 0, sum_1 = 0, sum_2 = 0, sum_3 = 0;
    for (int k = 0; k < kNumEntries; ++k) {
      sum_0 += row[k] * other[k];
      sum_1 += row[k] * other[k + kNumEntries];
      sum_2 += row[k] * other[k + 2 * kNumEntries];
      sum_3 += row[k] * other[k + 3 * kNumEntries];
    }
    bits[j] = sum_0;
    bits[j + 1] = sum_1;
    bits[j + 2] = sum_2;
    bits[j + 3] = sum_3;
  }
  for (int j = 0; j < num_others; ++j) {
    bits[j] = std::bit_cast<int32_t>(static_cast<float>(bits[j]) * inverse_norm * inverse_norms[j]);
  }
}

bool AreClear(float best, float second) {
  // Squared distance of unit vectors is 2 - 2 cos.
  return 1.0 - best < kMaxDistanceRatio * kMaxDistanceRatio * (1.0 - second);
}

// The highest similarity so far in each lane, and the second highest.
struct BestLanes {
  std::vector<int32_t> best, second, index;

  explicit BestLanes(int num_lanes)
      : best(static_cast<size_t>(num_lanes), 0),
        second(static_cast<size_t>(num_lanes), 0),
        index(static_cast<size_t>(num_lanes), -1) {}

  bool IsClearAt(int lane) const {
    const auto i = static_cast<size_t>(lane);
    return AreClear(CosineOf(best[i]), CosineOf(second[i]));
  }
};

// Offers candidate number `candidate` to each lane. An equal one does not replace an earlier one.
FREELSD_SEVERAL_TARGETS void Offer(const int32_t* __restrict__ bits,
                                   int candidate,
                                   int num_lanes,
                                   int32_t* __restrict__ best,
                                   int32_t* __restrict__ second,
                                   int32_t* __restrict__ index) {
  for (int lane = 0; lane < num_lanes; ++lane) {
    const int32_t offered = bits[lane], held = best[lane];
    const int32_t loser = std::min(offered, held);
    second[lane] = std::max(second[lane], loser);
    index[lane] = offered > held ? candidate : index[lane];
    best[lane] = std::max(offered, held);
  }
}

// The nearest of one row's candidates; -1 where the second nearest is about as near. Internal
// sentinel.
struct RowSearch {
  std::array<int32_t, kNumLanes> best, second, index;

  int NearestOf(const std::vector<int32_t>& bits) {
    best.fill(0);
    second.fill(0);
    index.fill(-1);
    for (size_t j = 0; j < bits.size(); j += kNumLanes) {
      Offer(bits.data() + j,
            static_cast<int>(j),
            kNumLanes,
            best.data(),
            second.data(),
            index.data());
    }
    int32_t first = 0, next = 0;
    int nearest = -1;
    for (int lane = 0; lane < kNumLanes; ++lane) {
      next = std::max({next, second[lane], std::min(first, best[lane])});
      if (best[lane] > first) {
        first = best[lane];
        nearest = index[lane] + lane;
      }
    }
    return AreClear(CosineOf(first), CosineOf(next)) ? nearest : -1;
  }
};

cv::Mat UnitRows(const cv::Mat& bytes) {
  cv::Mat unit;
  bytes.convertTo(unit, CV_32F);
  for (int row = 0; row < unit.rows; ++row) {
    cv::Mat line = unit.row(row);
    line /= std::max(cv::norm(line), 1.0);
  }
  return unit;
}

// The two highest similarities so far. The second starts at the similarity of unrelated points,
// because a small neighbourhood may hold no second candidate.
struct BestTwo {
  int index = -1;
  float best = kUnrelatedCosine;
  float second = kUnrelatedCosine;

  void Offer(int candidate, float cosine) {
    if (cosine > best) {
      second = std::exchange(best, cosine);
      index = candidate;
    } else {
      second = std::max(second, cosine);
    }
  }
  bool IsClear() const { return index >= 0 && AreClear(best, second); }
};

// Points by square cells with the radius as their side.
using Buckets = std::map<std::pair<int, int>, std::vector<int>>;

std::pair<int, int> CellOf(const Eigen::Vector2d& point, double width) {
  return {static_cast<int>(std::floor(point.x() / width)),
          static_cast<int>(std::floor(point.y() / width))};
}

// Points in the nine cells around a place.
std::vector<int> Nearby(const Buckets& buckets, const std::pair<int, int>& cell) {
  std::vector<int> nearby;
  for (int x = cell.first - 1; x <= cell.first + 1; ++x) {
    for (int y = cell.second - 1; y <= cell.second + 1; ++y) {
      const auto bucket = buckets.find({x, y});
      if (bucket == buckets.end()) continue;
      nearby.insert(nearby.end(), bucket->second.begin(), bucket->second.end());
    }
  }
  return nearby;
}

}  // namespace

std::vector<IndexPair> MatchDescriptors(const cv::Mat& a, const cv::Mat& b) {
  if (a.rows < 2 || b.rows < 2) return {};
  const WideRows wide_a = WideRowsOf(a), wide_b = WideRowsOf(b);
  const int num_lanes = static_cast<int>(wide_b.inverse_norm.size());
  BestLanes of_b(num_lanes);
  std::vector<int> b_of_a(static_cast<size_t>(a.rows));
  std::vector<int32_t> bits(static_cast<size_t>(num_lanes));
  RowSearch search;
  for (int i = 0; i < a.rows; ++i) {
    Cosines(wide_a.Row(i),
            wide_a.inverse_norm[static_cast<size_t>(i)],
            wide_b.entries.data(),
            wide_b.inverse_norm.data(),
            num_lanes,
            bits.data());
    b_of_a[static_cast<size_t>(i)] = search.NearestOf(bits);
    Offer(bits.data(), i, num_lanes, of_b.best.data(), of_b.second.data(), of_b.index.data());
  }
  std::vector<IndexPair> matches;
  for (int i = 0; i < a.rows; ++i) {
    const int j = b_of_a[static_cast<size_t>(i)];
    if (j >= 0 && of_b.index[static_cast<size_t>(j)] == i && of_b.IsClearAt(j)) {
      matches.push_back({i, j});
    }
  }
  return matches;
}

std::vector<IndexPair> MatchDescriptorsNear(const DescribedPoints& a,
                                            const DescribedPoints& b,
                                            double radius) {
  if (a.points.empty() || b.points.empty()) return {};
  const cv::Mat1f unit_a = UnitRows(a.descriptors), unit_b = UnitRows(b.descriptors);
  Buckets buckets;
  for (size_t j = 0; j < b.points.size(); ++j) {
    buckets[CellOf(b.points[j], radius)].push_back(static_cast<int>(j));
  }
  std::vector<BestTwo> of_a(a.points.size()), of_b(b.points.size());
  for (size_t i = 0; i < a.points.size(); ++i) {
    const Eigen::Map<const Eigen::VectorXf> row_a(unit_a[static_cast<int>(i)], unit_a.cols);
    for (const int j : Nearby(buckets, CellOf(a.points[i], radius))) {
      if ((a.points[i] - b.points[static_cast<size_t>(j)]).norm() > radius) continue;
      const float cosine = row_a.dot(Eigen::Map<const Eigen::VectorXf>(unit_b[j], unit_b.cols));
      of_a[i].Offer(j, cosine);
      of_b[static_cast<size_t>(j)].Offer(static_cast<int>(i), cosine);
    }
  }
  std::vector<IndexPair> matches;
  for (size_t i = 0; i < of_a.size(); ++i) {
    if (!of_a[i].IsClear()) continue;
    const BestTwo& back = of_b[static_cast<size_t>(of_a[i].index)];
    if (back.index == static_cast<int>(i) && back.IsClear()) {
      matches.push_back({static_cast<int>(i), of_a[i].index});
    }
  }
  return matches;
}

}  // namespace freelsd
