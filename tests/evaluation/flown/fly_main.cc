// freelsd-fly: emergency recall over worlds whose truth is known; every told path is flown.
//
// FOLDER/SEED is the data folder of a server to which the flight of that world was sent: see
// fly.sh.
#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <random>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tests/evaluation/flown/flown_recall.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {
namespace {

struct Arguments {
  std::string folder;
  int num_worlds = 16;
  uint64_t seed = 3000;
  int num_recalls = 1000;
};

constexpr size_t kMaxBytesOfCache = size_t{256} << 20;
constexpr double kMaxSurplusM = 2.0;

struct Counts {
  int recalls = 0;
  int with_sites = 0;
  int paths = 0;
  int with_terrain = 0;
  int paths_in_known_wind = 0;
  int surplus_in_known_wind = 0;
  int wrong_heights = 0;
  double worst_height_error_m = 0.0;
  // Above mapped terrain, on the way to the final, of paths with a known terrain margin.
  double least_height_m = 1e9;
  // By Obstacle.
  std::array<int, 5> met{};
};

const char* NameOf(Obstacle obstacle) {
  constexpr std::array<const char*, 5> kNames{
      "nothing", "terrain on a map", "terrain off maps", "terrain in a circle", "terrain on final"};
  return kNames[static_cast<size_t>(obstacle)];
}

void Tell(uint64_t seed, int number, const FlownPath& path, const std::string& what) {
  std::cout << "seed " << seed << ", recall " << number << ", site " << path.site_id << ": " << what
            << "; met " << NameOf(path.obstacle) << " (" << CoverName(path.cover)
            << (path.is_wire ? ", wire" : "") << ") at " << path.met_in_world.transpose()
            << ", terrain margin "
            << (path.terrain_margin_m ? std::to_string(*path.terrain_margin_m) : "unknown")
            << " m, surplus " << path.surplus_height_m << " m, height error " << path.height_error_m
            << " m\n";
}

void Count(uint64_t seed, int number, bool has_wind, const FlownPath& path, Counts& counts) {
  ++counts.paths;
  counts.with_terrain += path.terrain_margin_m.has_value();
  ++counts.met[static_cast<size_t>(path.obstacle)];
  counts.paths_in_known_wind += has_wind;
  counts.surplus_in_known_wind += has_wind && path.surplus_height_m > kMaxSurplusM;
  if (path.obstacle != Obstacle::kNone) Tell(seed, number, path, "flew into terrain");
  if (path.terrain_margin_m && path.least_height_m) {
    counts.least_height_m = std::min(counts.least_height_m, *path.least_height_m);
  }
  const double error = std::abs(path.height_error_m);
  counts.worst_height_error_m = std::max(counts.worst_height_error_m, error);
  if (error > path.max_height_error_m) {
    ++counts.wrong_heights;
    Tell(seed, number, path, "arrived at another height");
  }
}

void FlyWorld(const Arguments& arguments, int index, Counts& counts) {
  const uint64_t seed = arguments.seed + static_cast<uint64_t>(index);
  const auto data = std::filesystem::path(arguments.folder) / std::to_string(seed);
  if (!std::filesystem::exists(data / "freelsd.db")) {
    throw std::runtime_error("no data folder of a server: " + data.string());
  }
  const Storage storage(data);
  MapCache maps({kMaxBytesOfCache, kMaxBytesOfCache});
  ScenarioOptions options;
  options.takes_photographs = false;
  Mosaic mosaic;
  mosaic.Add(MakeScenario(seed, options, [](double) {}).world);
  const World& world = mosaic.worlds().front();
  const RecalledWorld recalled_world({storage, maps}, mosaic);
  std::mt19937 random(static_cast<uint32_t>(seed));
  const int end = (index + 1) * arguments.num_recalls / arguments.num_worlds;
  for (int number = index * arguments.num_recalls / arguments.num_worlds; number < end; ++number) {
    const EmergencyRequest request = RandomRequest(world, random);
    const RecalledWorld::Recalled recalled = recalled_world.Recall(request);
    ++counts.recalls;
    counts.with_sites += !recalled.paths.empty();
    for (const FlownPath& path : recalled.paths) {
      Count(seed, number, request.wind_in_world.has_value(), path, counts);
    }
  }
}

// Status 3 where a told path does not lead where it says.
int Run(const Arguments& arguments) {
  Counts counts;
  for (int i = 0; i < arguments.num_worlds; ++i) {
    FlyWorld(arguments, i, counts);
    std::cerr << "world " << i + 1 << " of " << arguments.num_worlds << ": " << counts.paths
              << " paths flown\n";
  }
  std::cout << std::fixed << std::setprecision(2);
  std::cout << "recalls " << counts.recalls << ", with a site in reach " << counts.with_sites
            << "\npaths flown " << counts.paths << ", with a known terrain margin "
            << counts.with_terrain << ", least height above mapped terrain there "
            << counts.least_height_m << " m\nsurplus above 2 m in known wind "
            << counts.surplus_in_known_wind << " of " << counts.paths_in_known_wind
            << "\narrival height beyond 5 m and 5 % of the height lost " << counts.wrong_heights
            << ", largest error " << counts.worst_height_error_m << " m\n";
  for (size_t i = 1; i < counts.met.size(); ++i) {
    std::cout << "flew into " << NameOf(static_cast<Obstacle>(i)) << " " << counts.met[i] << "\n";
  }
  const bool is_right =
      counts.wrong_heights == 0 && counts.met[static_cast<size_t>(Obstacle::kOnMap)] == 0;
  return is_right ? 0 : 3;
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Flies the paths that emergency recall tells over seeded worlds");
    app.add_option("--folder", arguments.folder, "data folders of the worlds, by seed")->required();
    app.add_option("--worlds", arguments.num_worlds, "number of worlds")
        ->check(CLI::Range(1, 1000));
    app.add_option("--seed", arguments.seed, "seed of the first world; the others follow");
    app.add_option("--recalls", arguments.num_recalls, "recalls over all worlds")
        ->check(CLI::Range(1, 1000000));
    CLI11_PARSE(app, argc, argv);
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-fly: " << error.what() << "\n";
    return 1;
  }
}
