// The layout of the countryside. It is planned in a frame of its own, turned so that +x is
// downwind: which fields have an open approach follows from where things stand there.
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/synthetic/noise.h"
#include "tests/synthetic/world.h"

namespace freelsd {
namespace {

// Purposes of randomness.
enum Purpose : uint64_t {
  kLayout = 1,
  kHills,
  kRolls,
  kSwells,
  kTufts,
  kSoilClods,
  kBushes,
  kRoadWay,
  kRagged
};

// Parcels: edges across the layout, metres, before they are moved a little by the seed. The one in
// the middle, [1][2], is the good meadow; its downwind neighbour stays low.
constexpr double kEdgesX[] = {-330.0, -212.0, -102.0, 24.0, 128.0, 232.0, 340.0};
constexpr double kEdgesY[] = {-330.0, -238.0, -142.0, -47.0, 56.0, 152.0, 244.0, 340.0};
constexpr int kNumCols = 6;
constexpr int kNumRows = 7;
constexpr int kMiddleCol = 2;
constexpr int kMiddleRow = 3;
constexpr double kEdgeJitterM = 6.0;
// Between the good meadow and its loiter circles nothing tall grows: x from, to; y from, to.
constexpr double kOpenZone[4] = {-85.0, 118.0, -52.0, 118.0};
constexpr double kRoadHalfWidthM = 2.6;
// Standard deviation of a border's raggedness.
constexpr double kRaggedM = 0.35;
constexpr double kVergeM = 1.5;

class Planner {
 public:
  explicit Planner(const WorldOptions& options)
      : options_(options), random_(MixSeed(options.seed, kLayout)) {
    wind_heading_ = Uniform(0.0, 2.0 * kPi);
    downwind_ = DirectionOf(wind_heading_);
    for (int i = 0; i <= kNumCols; ++i) edges_x_[i] = kEdgesX[i] + Uniform(-1, 1) * kEdgeJitterM;
    for (int i = 0; i <= kNumRows; ++i) edges_y_[i] = kEdgesY[i] + Uniform(-1, 1) * kEdgeJitterM;
  }

  World Plan() {
    World world = EmptyWorld();
    ChooseParcels();
    LayGround(world);
    PlantBorders(world);
    PlantWoods(world);
    BuildFarm(world);
    return world;
  }

 private:
  double Uniform(double low, double high) {
    const double unit = static_cast<double>(random_() >> 11) * 0x1.0p-53;
    return low + (high - low) * unit;
  }

  Eigen::Vector2d WorldFromLayout(const Eigen::Vector2d& p) const {
    return p.x() * downwind_ + p.y() * Eigen::Vector2d(-downwind_.y(), downwind_.x());
  }
  Eigen::Vector2d LayoutFromWorld(double x, double y) const {
    return {x * downwind_.x() + y * downwind_.y(), y * downwind_.x() - x * downwind_.y()};
  }

  World EmptyWorld() {
    World world;
    world.seed = options_.seed;
    world.size_m = options_.size_m;
    world.cell_size_m = options_.cell_size_m;
    world.origin = options_.origin;
    world.wind_in_world = options_.wind_speed_mps * downwind_;
    const double elevation = RadFromDeg(Uniform(42.0, 56.0));
    const Eigen::Vector2d azimuth = DirectionOf(RadFromDeg(Uniform(120.0, 240.0)));
    world.sun_in_world << azimuth * std::cos(elevation), std::sin(elevation);
    const int n = static_cast<int>(std::lround(options_.size_m / options_.cell_size_m));
    world.ground.create(n, n);
    world.surface.create(n, n);
    world.cover.create(n, n);
    world.variant.create(n, n);
    return world;
  }

  void ChooseParcels() {
    for (int row = 0; row < kNumRows; ++row) {
      for (int col = 0; col < kNumCols; ++col) {
        const double dice = Uniform(0.0, 1.0);
        Cover cover = Cover::kTree;
        if (dice < 0.27)
          cover = Cover::kMeadow;
        else if (dice < 0.50)
          cover = Cover::kStubble;
        else if (dice < 0.66)
          cover = Cover::kSoil;
        else if (dice < 0.80)
          cover = Cover::kScrub;
        covers_[row][col] = cover;
        variants_[row][col] = static_cast<uint8_t>(Uniform(0.0, 255.9));
      }
    }
    covers_[kMiddleRow][kMiddleCol] = Cover::kMeadow;
    covers_[kMiddleRow][kMiddleCol + 1] = Cover::kStubble;
    covers_[kMiddleRow + 1][kMiddleCol] = Cover::kSoil;
    covers_[kMiddleRow + 1][kMiddleCol + 1] = Cover::kMeadow;
    covers_[kMiddleRow + 1][kMiddleCol + 2] = Cover::kStubble;
    covers_[kMiddleRow][kMiddleCol - 1] = Cover::kTree;
    covers_[kMiddleRow - 1][kMiddleCol + 1] = Cover::kGravel;
    covers_[kMiddleRow - 1][kMiddleCol] = Cover::kMeadow;
  }

  static int Band(const double* edges, int count, double coordinate) {
    int band = 0;
    while (band + 1 < count && coordinate >= edges[band + 1]) ++band;
    return band;
  }

  // Sideways place of the road's middle line.
  double RoadAt(double x) const { return edges_y_[kMiddleRow] - 6.0 + 7.0 * road_way_.At(x, 0.0); }

  void LayGround(World& world) {
    const Noise hills(MixSeed(options_.seed, kHills), 150.0);
    const Noise rolls(MixSeed(options_.seed, kRolls), 60.0);
    const Noise tufts(MixSeed(options_.seed, kTufts), 0.5);
    const Noise clods(MixSeed(options_.seed, kSoilClods), 0.4);
    const Noise bushes(MixSeed(options_.seed, kBushes), 1.3);
    const Noise swells(MixSeed(options_.seed, kSwells), 3.0);
    const double relief = options_.relief_sd_m;
    cv::parallel_for_({0, world.num_cells()}, [&](const cv::Range& rows) {
      for (int row = rows.start; row < rows.end; ++row) {
        for (int col = 0; col < world.num_cells(); ++col) {
          const double x = world.CellCenter(col), y = world.CellCenter(row);
          const Eigen::Vector2d place = LayoutFromWorld(x, y);
          // Borders were ploughed by people, not drawn with a ruler.
          const Eigen::Vector2d ragged =
              place + kRaggedM * Eigen::Vector2d(ragged_.At(x, y), ragged_.At(x + 500.0, y));
          // Upwind behind the wood the land rises to a hillside too steep to land on.
          const double rise = std::clamp((-place.x() - 190.0) / 90.0, 0.0, 1.0);
          const double ground = relief * (hills.At(x, y) + 0.10 * rolls.At(x, y) +
                                          6.0 * rise * rise * (3.0 - 2.0 * rise));
          const Cover cover = CoverFor(place, ragged);
          double height = 0.0;
          if (cover == Cover::kMeadow) height = 0.04 * tufts.At(x, y) + 0.02 * swells.At(x, y);
          if (cover == Cover::kSoil || cover == Cover::kStubble) height = 0.06 * clods.At(x, y);
          if (cover == Cover::kScrub) height = std::max(0.0, 0.8 + 0.35 * bushes.At(x, y));
          world.ground(row, col) = static_cast<float>(ground);
          world.surface(row, col) = static_cast<float>(ground + height);
          world.cover(row, col) = static_cast<uint8_t>(cover);
          world.variant(row, col) = variants_[Row(ragged)][Col(ragged)];
        }
      }
    });
  }

  // Cover of the ground itself: woods stand on scrub, the road has verges of rough growth.
  Cover CoverFor(const Eigen::Vector2d& place, const Eigen::Vector2d& ragged) const {
    const double off_road = std::abs(place.y() - RoadAt(place.x()));
    if (off_road < kRoadHalfWidthM) return Cover::kRoad;
    if (off_road < kRoadHalfWidthM + kVergeM) return Cover::kMeadow;
    const Cover cover = covers_[Row(ragged)][Col(ragged)];
    return cover == Cover::kTree ? Cover::kScrub : cover;
  }
  int Row(const Eigen::Vector2d& place) const { return Band(edges_y_, kNumRows, place.y()); }
  int Col(const Eigen::Vector2d& place) const { return Band(edges_x_, kNumCols, place.x()); }

  bool InOpenZone(const Eigen::Vector2d& place, double margin_m) const {
    return place.x() > kOpenZone[0] - margin_m && place.x() < kOpenZone[1] + margin_m &&
           place.y() > kOpenZone[2] - margin_m && place.y() < kOpenZone[3] + margin_m;
  }

  Tree RandomTree(const Eigen::Vector2d& place) {
    Tree tree;
    tree.center = WorldFromLayout(place);
    tree.height_m = Uniform(6.0, 15.0);
    tree.radius_m = std::clamp(tree.height_m * Uniform(0.28, 0.42), 2.2, 5.5);
    tree.variant = static_cast<uint8_t>(Uniform(0.0, 255.9));
    return tree;
  }

  // Every border has its chance of a hedge, a row of trees, or nothing.
  void PlantBorders(World& world) {
    for (int row = 0; row <= kNumRows; ++row) {
      for (int col = 0; col < kNumCols; ++col) {
        if (row == kMiddleRow) continue;  // the road runs there
        PlantBorder(world, {edges_x_[col], edges_y_[row]}, {edges_x_[col + 1], edges_y_[row]});
      }
    }
    for (int col = 0; col <= kNumCols; ++col) {
      for (int row = 0; row < kNumRows; ++row) {
        PlantBorder(world, {edges_x_[col], edges_y_[row]}, {edges_x_[col], edges_y_[row + 1]});
      }
    }
  }

  void PlantBorder(World& world, const Eigen::Vector2d& start, const Eigen::Vector2d& end) {
    const double dice = Uniform(0.0, 1.0);
    const Eigen::Vector2d along = (end - start).normalized();
    const double length = (end - start).norm();
    if (dice < 0.4) {
      Hedge hedge;
      // Gates at both ends; also keeps hedges off the road.
      hedge.start = WorldFromLayout(start + 11.0 * along);
      hedge.end = WorldFromLayout(end - Uniform(11.0, 30.0) * along);
      hedge.height_m = Uniform(1.4, 2.2);
      world.Plant(hedge);
    } else if (dice < 0.62) {
      for (double s = Uniform(13.0, 20.0); s < length - 13.0; s += Uniform(7.0, 22.0)) {
        const Eigen::Vector2d place = start + s * along;
        if (!InOpenZone(place, 4.0)) world.Plant(RandomTree(place));
      }
    }
  }

  void PlantWoods(World& world) {
    for (int row = 0; row < kNumRows; ++row) {
      for (int col = 0; col < kNumCols; ++col) {
        if (covers_[row][col] == Cover::kTree) PlantWood(world, row, col);
      }
    }
    PlantSingleTrees(world);
  }

  void PlantWood(World& world, int row, int col) {
    constexpr double kSpacingM = 6.0;
    for (double y = edges_y_[row] + 4.0; y < edges_y_[row + 1] - 4.0; y += kSpacingM) {
      for (double x = edges_x_[col] + 4.0; x < edges_x_[col + 1] - 4.0; x += kSpacingM) {
        const Eigen::Vector2d place(x + Uniform(-2.2, 2.2), y + Uniform(-2.2, 2.2));
        if (std::abs(place.y() - RoadAt(place.x())) < kRoadHalfWidthM + 4.0) continue;
        if (InOpenZone(place, 4.0) || Uniform(0.0, 1.0) < 0.06) continue;
        Tree tree = RandomTree(place);
        tree.height_m = std::max(tree.height_m, 8.0);
        world.Plant(tree);
      }
    }
  }

  void PlantSingleTrees(World& world) {
    constexpr int kNumTrees = 30;
    for (int i = 0; i < kNumTrees; ++i) {
      const Eigen::Vector2d place(Uniform(-280.0, 280.0), Uniform(-280.0, 280.0));
      const bool on_road = std::abs(place.y() - RoadAt(place.x())) < kRoadHalfWidthM + 5.0;
      const Tree tree = RandomTree(place);
      if (!on_road && !InOpenZone(place, 6.0)) world.Plant(tree);
    }
  }

  // Four buildings around a yard, beside the road.
  void BuildFarm(World& world) {
    const Eigen::Vector2d yard(0.5 * (edges_x_[kMiddleCol + 1] + edges_x_[kMiddleCol + 2]),
                               edges_y_[kMiddleRow] - 42.0);
    const Eigen::Vector2d places[] = {{-22.0, 10.0}, {6.0, 16.0}, {24.0, -6.0}, {-10.0, -18.0}};
    for (int i = 0; i < 4; ++i) {
      House house;
      house.center = WorldFromLayout(yard + places[i]);
      house.heading = wind_heading_ + (i % 2) * 0.5 * kPi + Uniform(-0.15, 0.15);
      house.length_m = Uniform(11.0, 22.0);
      house.width_m = Uniform(7.0, 10.0);
      house.eaves_m = Uniform(3.0, 5.0);
      house.ridge_m = house.eaves_m + Uniform(2.0, 3.2);
      house.variant = static_cast<uint8_t>(i);
      world.Build(house);
    }
  }

  WorldOptions options_;
  std::mt19937_64 random_;
  Noise road_way_{MixSeed(options_.seed, kRoadWay), 130.0};
  Noise ragged_{MixSeed(options_.seed, kRagged), 4.0};
  double wind_heading_ = 0.0;
  Eigen::Vector2d downwind_ = Eigen::Vector2d::UnitX();
  double edges_x_[kNumCols + 1] = {};
  double edges_y_[kNumRows + 1] = {};
  Cover covers_[kNumRows][kNumCols] = {};
  uint8_t variants_[kNumRows][kNumCols] = {};
};

}  // namespace

World MakeFarmland(const WorldOptions& options) {
  options.Check();
  World world = Planner(options).Plan();
  world.Paint();
  world.Light();
  return world;
}

World MakeMeadowPlane(const WorldOptions& options) {
  options.Check();
  World world;
  world.seed = options.seed;
  world.size_m = options.size_m;
  world.cell_size_m = options.cell_size_m;
  world.origin = options.origin;
  world.wind_in_world = Eigen::Vector2d(options.wind_speed_mps, 0.0);
  world.sun_in_world = Eigen::Vector3d(0.5, -0.5, 1.0).normalized();
  const int n = static_cast<int>(std::lround(options.size_m / options.cell_size_m));
  world.ground = cv::Mat1f(n, n, 0.0f);
  world.surface = cv::Mat1f(n, n, 0.0f);
  world.cover = cv::Mat1b(n, n, static_cast<uint8_t>(Cover::kMeadow));
  world.variant = cv::Mat1b(n, n, static_cast<uint8_t>(0));
  world.Paint();
  world.Light();
  return world;
}

}  // namespace freelsd
