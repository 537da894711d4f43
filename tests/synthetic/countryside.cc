// Countryside as it comes: the square is split again and again into parcels, each of which gets a
// cover, borders and whatever people and weather have left on it.
#include <algorithm>
#include <cmath>

#include "tests/synthetic/countryside_lots.h"
#include "tests/synthetic/countryside_relief.h"
#include "tests/synthetic/crops.h"
#include "tests/synthetic/noise.h"

namespace freelsd {
namespace {

// Purposes of randomness.
enum Purpose : uint64_t { kLayout = 601, kRagged = 609, kMovers = 610, kYoungTrees = 611 };

constexpr double kLaneHalfWidthM = 2.6;
constexpr double kVergeM = 1.5;
constexpr double kRaggedM = 0.35;

class Countryside {
 public:
  explicit Countryside(const WorldOptions& options)
      : options_(options), random_(MixSeed(options.seed, kLayout)) {}

  World Make() {
    World world = Empty();
    const double reach = 0.75 * options_.size_m;  // the layout is turned
    layout_ = LotLayout({-reach, -reach}, {reach, reach}, random_);
    const double east = Uniform(-0.4, 0.4), north = Uniform(-0.4, 0.4);
    relief_.PlaceHill(options_.size_m * Eigen::Vector2d(east, north));
    LayGround(world);
    for (const Lot& lot : layout_.lots()) Furnish(world, lot);
    for (const Split& split : layout_.splits()) PlantBorder(world, split);
    PlantSingleTrees(world);
    PlantYoungTrees(world);
    if (Uniform(0, 1) < 0.35) BuildPowerLine(world);
    AddMovers(world);
    return world;
  }

 private:
  double Uniform(double low, double high) { return random_.Uniform(low, high); }

  Eigen::Vector2d WorldFromLayout(const Eigen::Vector2d& p) const {
    return p.x() * forward_ + p.y() * Eigen::Vector2d(-forward_.y(), forward_.x());
  }
  Eigen::Vector2d LayoutFromWorld(const Eigen::Vector2d& p) const {
    return {p.dot(forward_), p.y() * forward_.x() - p.x() * forward_.y()};
  }

  World Empty() {
    World world;
    world.seed = options_.seed;
    world.size_m = options_.size_m;
    world.cell_size_m = options_.cell_size_m;
    world.origin = options_.origin;
    forward_ = DirectionOf(Uniform(0.0, 2.0 * kPi));
    world.wind_in_world = options_.wind_speed_mps * DirectionOf(Uniform(0.0, 2.0 * kPi));
    const double elevation = RadFromDeg(Uniform(32.0, 60.0));
    world.sun_in_world << DirectionOf(RadFromDeg(Uniform(100.0, 260.0))) * std::cos(elevation),
        std::sin(elevation);
    const int n = static_cast<int>(std::lround(options_.size_m / options_.cell_size_m));
    for (cv::Mat1f* grid : {&world.ground, &world.surface}) grid->create(n, n);
    for (cv::Mat1b* grid : {&world.cover, &world.variant}) grid->create(n, n);
    return world;
  }

  double GrowthAt(const Lot& lot, Cover cover, double x, double y) const {
    if (cover == Cover::kMeadow && lot.feature == Feature::kTussocks) {
      return relief_.TussocksAt(x, y);
    }
    return relief_.GrowthAt(cover, lot.variant, x, y);
  }

  void LayGround(World& world) const {
    ForEachCell(world, [&](int row, int col) { LayCell(world, row, col); });
  }

  void LayCell(World& world, int row, int col) const {
    const double x = world.CellCenter(col), y = world.CellCenter(row);
    const Eigen::Vector2d place = LayoutFromWorld({x, y});
    // Borders were ploughed by people, not drawn with a ruler.
    const Eigen::Vector2d ragged =
        place + kRaggedM * Eigen::Vector2d(ragged_.At(x, y), ragged_.At(x + 500.0, y));
    const Lot& lot = layout_.LotAt(ragged);
    const double to_lane = layout_.ToLane(place);
    Cover cover = lot.cover == Cover::kTree ? Cover::kScrub : lot.cover;
    if (to_lane < kLaneHalfWidthM + kVergeM) cover = Cover::kMeadow;
    if (to_lane < kLaneHalfWidthM) cover = Cover::kRoad;
    // Tractors drive straighter than ploughs leave a border.
    const Eigen::Vector2d driven = place + 0.2 * (ragged - place) - lot.min;
    if (cover == Cover::kCrop && IsBare(CropOf(lot.variant), driven, lot.Size())) {
      cover = Cover::kSoil;
    }
    double ground = relief_.GroundAt(x, y);
    if (cover == Cover::kWater) {  // a pond is level, and lower than its banks
      const Eigen::Vector2d middle = WorldFromLayout(lot.Middle());
      ground = relief_.GroundAt(middle.x(), middle.y()) - 0.5;
    }
    world.ground(row, col) = static_cast<float>(ground);
    world.surface(row, col) = static_cast<float>(ground + GrowthAt(lot, cover, x, y));
    world.cover(row, col) = static_cast<uint8_t>(cover);
    world.variant(row, col) = lot.variant;
  }

  // A place within a lot, in the layout.
  Eigen::Vector2d PlaceIn(const Lot& lot, double margin) {
    const double x = Uniform(lot.min.x() + margin, lot.max.x() - margin);
    const double y = Uniform(lot.min.y() + margin, lot.max.y() - margin);
    return {x, y};
  }

  void Furnish(World& world, const Lot& lot) {
    if (lot.cover == Cover::kTree) PlantWood(world, lot);
    if (lot.cover == Cover::kGravel) BuildFarm(world, lot);
    if (lot.cover != Cover::kMeadow) return;
    const double area = lot.Size().prod();
    switch (lot.feature) {
      case Feature::kGood:
      case Feature::kTussocks:
        return;
      case Feature::kBoulders:
        return Scatter(lot, static_cast<int>(area / 400.0), [&](const Eigen::Vector2d& place) {
          const double radius = Uniform(0.5, 1.4);
          world.Put(Boulder{place, radius, radius * Uniform(0.7, 1.1)});
        });
      case Feature::kAnimals:
        return Scatter(lot, 4 + static_cast<int>(area / 900.0), [&](const Eigen::Vector2d& place) {
          const uint8_t kind = static_cast<uint8_t>(Uniform(0, 2.99));
          world.Put(Block{place, Uniform(0, 2.0 * kPi), 2.1, 0.8, 1.4, Cover::kAnimal, kind});
        });
      case Feature::kBales:
        return Scatter(lot, 3 + static_cast<int>(area / 1200.0), [&](const Eigen::Vector2d& place) {
          world.Put(Block{place, Uniform(0, 2.0 * kPi), 1.5, 1.2, 1.3, Cover::kVehicle, 3});
        });
      case Feature::kParkedCars:
        return Scatter(lot, 2 + static_cast<int>(Uniform(0, 4)), [&](const Eigen::Vector2d& place) {
          const uint8_t paint = static_cast<uint8_t>(Uniform(0, 3.99));
          world.Put(Block{place, Uniform(0, 2.0 * kPi), 4.4, 1.8, 1.5, Cover::kVehicle, paint});
        });
      case Feature::kDitch:
        return DigAcross(world, lot);
    }
  }

  template <typename PutAt>
  void Scatter(const Lot& lot, int count, PutAt put_at) {
    for (int i = 0; i < count; ++i) put_at(WorldFromLayout(PlaceIn(lot, 2.0)));
  }

  void DigAcross(World& world, const Lot& lot) {
    const int axis = Uniform(0, 1) < 0.5 ? 0 : 1;
    Eigen::Vector2d start = lot.min, end = lot.max;
    start[axis] = lot.min[axis] + Uniform(0.25, 0.75) * lot.Size()[axis];
    end[axis] = lot.min[axis] + Uniform(0.25, 0.75) * lot.Size()[axis];
    world.Dig(Ditch{.start = WorldFromLayout(start),
                    .end = WorldFromLayout(end),
                    .width_m = Uniform(1.2, 2.4),
                    .depth_m = Uniform(0.5, 1.2)});
  }

  Tree RandomTree(const Eigen::Vector2d& place, bool is_leafless) {
    Tree tree;
    tree.center = WorldFromLayout(place);
    tree.height_m = Uniform(6.0, 16.0);
    tree.radius_m = std::clamp(tree.height_m * Uniform(0.28, 0.42), 2.2, 5.5);
    tree.variant = static_cast<uint8_t>(Uniform(0.0, 255.9));
    tree.is_leafless = is_leafless;
    return tree;
  }

  void PlantWood(World& world, const Lot& lot) {
    constexpr double kSpacingM = 6.0;
    const bool is_leafless = Uniform(0, 1) < 0.2;
    for (double y = lot.min.y() + 4.0; y < lot.max.y() - 4.0; y += kSpacingM) {
      for (double x = lot.min.x() + 4.0; x < lot.max.x() - 4.0; x += kSpacingM) {
        const Eigen::Vector2d place(x + Uniform(-2.2, 2.2), y + Uniform(-2.2, 2.2));
        if (layout_.ToLane(place) < kLaneHalfWidthM + 4.0 || Uniform(0, 1) < 0.06) continue;
        world.Plant(RandomTree(place, is_leafless));
      }
    }
  }

  void BuildFarm(World& world, const Lot& lot) {
    const int num_houses = 2 + static_cast<int>(Uniform(0, 3));
    for (int i = 0; i < num_houses; ++i) {
      House house;
      house.center = WorldFromLayout(PlaceIn(lot, 13.0));
      house.heading = HeadingOf(forward_) + (i % 2) * 0.5 * kPi + Uniform(-0.15, 0.15);
      house.length_m = Uniform(10.0, 22.0);
      house.width_m = Uniform(7.0, 10.0);
      house.eaves_m = Uniform(3.0, 5.5);
      house.ridge_m = house.eaves_m + Uniform(1.5, 3.2);
      house.variant = static_cast<uint8_t>(i);
      world.Build(house);
    }
    Scatter(lot, 3, [&](const Eigen::Vector2d& place) {
      world.Put(Block{.center = place, .heading = Uniform(0, 2.0 * kPi)});
    });
  }

  // Every border has its chance of a hedge, trees, a fence, a ditch, or nothing.
  void PlantBorder(World& world, const Split& split) {
    if (split.is_lane) return ParkOnLane(world, split);
    const double length = (split.end - split.start).norm();
    const Eigen::Vector2d along = (split.end - split.start) / length;
    // A long border is not the same all along.
    for (double s = 5.0; s < length - 12.0;) {
      const double piece = std::min(Uniform(40.0, 110.0), length - 5.0 - s);
      const Eigen::Vector2d start = split.start + s * along;
      PlantPiece(world, start, start + (piece - 6.0) * along);
      s += piece;
    }
  }

  void PlantPiece(World& world, const Eigen::Vector2d& start, const Eigen::Vector2d& end) {
    const double dice = Uniform(0, 1);
    const Eigen::Vector2d from = WorldFromLayout(start), to = WorldFromLayout(end);
    if (dice < 0.28) {
      world.Plant(Hedge{.start = from, .end = to, .height_m = Uniform(1.2, 2.6)});
    } else if (dice < 0.48) {
      const bool is_leafless = Uniform(0, 1) < 0.25;
      const Eigen::Vector2d along = (end - start).normalized();
      for (double s = 4.0; s < (end - start).norm(); s += Uniform(7.0, 20.0)) {
        world.Plant(RandomTree(start + s * along, is_leafless));
      }
    } else if (dice < 0.68) {
      world.Build(Fence{.start = from, .end = to});
    } else if (dice < 0.78) {
      world.Dig(Ditch{.start = from, .end = to});
    }
  }

  void ParkOnLane(World& world, const Split& split) {
    const Eigen::Vector2d span = split.end - split.start;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d place = split.start + Uniform(0.05, 0.95) * span;
      world.Put(Block{.center = WorldFromLayout(place),
                      .heading = HeadingOf(WorldFromLayout(span)),
                      .variant = static_cast<uint8_t>(Uniform(0, 3.99))});
    }
  }

  void PlantSingleTrees(World& world) {
    constexpr int kNumTrees = 22;
    const double half = 0.5 * options_.size_m;
    for (int i = 0; i < kNumTrees; ++i) {
      const Eigen::Vector2d place = LayoutFromWorld({Uniform(-half, half), Uniform(-half, half)});
      const Cover cover = layout_.LotAt(place).cover;
      const Tree tree = RandomTree(place, Uniform(0, 1) < 0.2);
      if (cover == Cover::kWater || layout_.ToLane(place) < kLaneHalfWidthM + 5.0) continue;
      world.Plant(tree);
    }
  }

  // Young trees and tall bushes, many without leaves, along borders and in the open. From numbers
  // of their own: what else stands does not depend on them.
  void PlantYoungTrees(World& world) {
    constexpr double kPerSquareM = 1.0 / 4000.0;
    constexpr double kAlongBorder = 0.6;  // share
    Random random(MixSeed(options_.seed, kYoungTrees));
    const double half = 0.5 * options_.size_m;
    const int num_trees = static_cast<int>(kPerSquareM * options_.size_m * options_.size_m);
    for (int i = 0; i < num_trees; ++i) {
      const double east = random.Uniform(-half, half), north = random.Uniform(-half, half);
      Eigen::Vector2d place = LayoutFromWorld({east, north});
      if (random.Uniform(0, 1) < kAlongBorder) place = layout_.LotAt(place).NearestOnBorder(place);
      Tree tree;
      tree.center = WorldFromLayout(place);
      tree.height_m = random.Uniform(1.8, 5.0);
      tree.radius_m = random.Uniform(0.8, 2.0);
      tree.variant = static_cast<uint8_t>(random.Uniform(0.0, 255.9));
      tree.is_leafless = random.Uniform(0, 1) < 0.5;
      const bool is_on_water = layout_.LotAt(place).cover == Cover::kWater;
      if (!is_on_water && layout_.ToLane(place) > kLaneHalfWidthM + 2.5) world.Plant(tree);
    }
  }

  // From numbers of their own: what stands does not depend on what moves.
  void AddMovers(World& world) {
    random_ = Random(MixSeed(options_.seed, kMovers));
    for (const Split& split : layout_.splits()) {
      if (split.is_lane) DriveAlong(world, split);
    }
    for (const Lot& lot : layout_.lots()) {
      if (lot.cover != Cover::kMeadow || Uniform(0, 1) > 0.3) continue;
      Scatter(lot, 1 + static_cast<int>(Uniform(0, 3)), [&](const Eigen::Vector2d& place) {
        const uint8_t kind = static_cast<uint8_t>(Uniform(0, 2.99));
        const Block animal{place, Uniform(0, 2.0 * kPi), 2.1, 0.8, 1.4, Cover::kAnimal, kind};
        world.movers.push_back({animal, Uniform(0.3, 1.2), Uniform(3.0, 15.0)});
      });
    }
  }

  // Two cars, one on each side of the lane.
  void DriveAlong(World& world, const Split& split) {
    const Eigen::Vector2d span = WorldFromLayout(split.end - split.start);
    const Eigen::Vector2d forward = span.normalized();
    const Eigen::Vector2d aside = 1.2 * Eigen::Vector2d(forward.y(), -forward.x());
    for (const double side : {1.0, -1.0}) {
      Block car;
      car.center = WorldFromLayout(side > 0.0 ? split.start : split.end) + side * aside;
      car.heading = HeadingOf(side * forward);
      car.variant = static_cast<uint8_t>(Uniform(0, 3.99));
      world.movers.push_back({car, Uniform(6.0, 16.0), span.norm()});
    }
  }

  void BuildPowerLine(World& world) {
    const double angle = Uniform(0, kPi);
    const Eigen::Vector2d along = DirectionOf(angle);
    const Eigen::Vector2d across(along.y(), -along.x());
    const Eigen::Vector2d middle = Uniform(-0.3, 0.3) * options_.size_m * across;
    world.Build(PowerLine{.start = middle - options_.size_m * along,
                          .end = middle + options_.size_m * along});
  }

  WorldOptions options_;
  Random random_;
  CountrysideRelief relief_{options_};
  Noise ragged_{MixSeed(options_.seed, kRagged), 4.0};
  Eigen::Vector2d forward_ = Eigen::Vector2d::UnitX();
  LotLayout layout_;
};

}  // namespace

World MakeCountryside(const WorldOptions& options) {
  options.Check();
  World world = Countryside(options).Make();
  world.Paint();
  world.Light();
  return world;
}

}  // namespace freelsd
