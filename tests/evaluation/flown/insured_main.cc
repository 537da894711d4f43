// freelsd-fly-routes: the landing insurance of random routes over mosaics of worlds whose truth is
// known; where the engine stops, what was told is flown.
//
// FOLDER/SEED is the data folder of a server to which the flights of a mosaic were sent: see
// insurance.sh.
#include <algorithm>
#include <exception>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <random>

#include <CLI/CLI.hpp>

#include "tests/evaluation/flown/insured_routes.h"

namespace freelsd {
namespace {

struct Arguments {
  std::string folder;
  int num_mosaics = 2;
  int side = 6;
  uint64_t seed = 57000;
  int num_routes = 25;
  int num_stops = 20;
};

constexpr size_t kMaxBytesOfCache = size_t{512} << 20;
constexpr uint64_t kSeedsOfMosaic = 100;
constexpr int kNumResamples = 10000;

std::vector<FlownRoute> FlyMosaic(const Arguments& arguments, int index) {
  const uint64_t seed = arguments.seed + kSeedsOfMosaic * static_cast<uint64_t>(index);
  const Storage storage(std::filesystem::path(arguments.folder) / std::to_string(seed));
  MapCache maps({kMaxBytesOfCache, kMaxBytesOfCache});
  const Mosaic mosaic = MakeMosaic(seed, arguments.side);
  RouteFlyer flyer({storage, maps}, mosaic);
  std::mt19937 random(static_cast<uint32_t>(seed));
  std::vector<FlownRoute> routes;
  for (int i = 0; i < arguments.num_routes; ++i) {
    const RouteRequest request = RandomRoute(mosaic, random);
    routes.push_back(flyer.Fly(request, arguments.num_stops, seed + static_cast<uint64_t>(i)));
    const FlownRoute& route = routes.back();
    std::cout << "mosaic " << seed << ", route " << i << ": " << route.num_covered_seconds << " of "
              << route.num_seconds << " s covered, " << route.num_covered << " of "
              << route.num_moments << " stops; told " << route.told_risk << ", failed "
              << route.num_failed << ", " << route.check_s << " s\n";
    for (const std::string& remark : route.remarks) std::cout << "  " << remark << "\n";
  }
  return routes;
}

// 95 % interval of failures less told risks, per covered moment: routes are drawn again.
std::pair<double, double> IntervalOf(const std::vector<FlownRoute>& routes) {
  std::mt19937 random(1);
  std::uniform_int_distribution<size_t> draw(0, routes.size() - 1);
  std::vector<double> excesses;
  for (int i = 0; i < kNumResamples; ++i) {
    double excess = 0.0;
    int num_covered = 0;
    for (size_t k = 0; k < routes.size(); ++k) {
      const FlownRoute& route = routes[draw(random)];
      excess += route.num_failed - route.told_risk;
      num_covered += route.num_covered;
    }
    excesses.push_back(excess / std::max(1, num_covered));
  }
  std::sort(excesses.begin(), excesses.end());
  return {excesses[kNumResamples / 40], excesses[kNumResamples - 1 - kNumResamples / 40]};
}

FlownRoute Together(const std::vector<FlownRoute>& routes) {
  FlownRoute all;
  for (const FlownRoute& route : routes) {
    all.num_moments += route.num_moments;
    all.num_seconds += route.num_seconds;
    all.num_covered_seconds += route.num_covered_seconds;
    all.num_different += route.num_different;
    all.num_covered += route.num_covered;
    all.told_risk += route.told_risk;
    all.num_failed += route.num_failed;
    all.num_failed_thin += route.num_failed_thin;
    for (const auto& [obstacle, count] : route.met) all.met[obstacle] += count;
    for (const auto& [kind, count] : route.fixes) all.fixes[kind] += count;
    all.num_gaps += route.num_gaps;
    all.num_wrong_fixes += route.num_wrong_fixes;
    all.check_s = std::max(all.check_s, route.check_s);
  }
  return all;
}

// Status 3 where an answer is not what recall says, or a clear way was none.
int Run(const Arguments& arguments) {
  std::vector<FlownRoute> routes;
  for (int i = 0; i < arguments.num_mosaics; ++i) {
    for (FlownRoute& route : FlyMosaic(arguments, i)) routes.push_back(std::move(route));
  }
  FlownRoute all = Together(routes);
  const auto [least, most] = IntervalOf(routes);
  std::cout << std::fixed << std::setprecision(3) << "routes " << routes.size() << ", seconds "
            << all.num_seconds << ", covered "
            << static_cast<double>(all.num_covered_seconds) / all.num_seconds << ", longest check "
            << all.check_s << " s\nengine stopped " << all.num_moments << ", samples unlike recall "
            << all.num_different << ", told covered " << all.num_covered << "\ntold risks "
            << all.told_risk << ", failures " << all.num_failed
            << " (fences, poles and wires alone besides: " << all.num_failed_thin
            << "), failures less told per covered stop [" << least << ", " << most
            << "]\nmet on the way where a map shows the ground " << all.met[Obstacle::kOnMap]
            << ", off maps " << all.met[Obstacle::kOffMap] << ", in circles "
            << all.met[Obstacle::kInCircle] << "\ngaps " << all.num_gaps << ", fixes: climb "
            << all.fixes["climb"] << ", offset " << all.fixes["offset"] << ", look "
            << all.fixes["look"] << "; not as told when flown " << all.num_wrong_fixes << "\n";
  const bool is_right =
      all.num_different == 0 && all.num_wrong_fixes == 0 && all.met[Obstacle::kOnMap] == 0;
  return is_right ? 0 : 3;
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Flies what the insurance of routes tells over mosaics of seeded worlds");
    app.add_option("--folder", arguments.folder, "data folders of the mosaics")->required();
    app.add_option("--mosaics", arguments.num_mosaics, "number of mosaics")
        ->check(CLI::Range(1, 100));
    app.add_option("--side", arguments.side, "worlds along one side")->check(CLI::Range(1, 10));
    app.add_option("--seed", arguments.seed, "seed of the first world of the first mosaic");
    app.add_option("--routes", arguments.num_routes, "routes over each mosaic")
        ->check(CLI::Range(1, 10000));
    app.add_option("--stops", arguments.num_stops, "stops of the engine on each route")
        ->check(CLI::Range(1, 1000));
    CLI11_PARSE(app, argc, argv);
    return freelsd::Run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "freelsd-fly-routes: " << error.what() << "\n";
    return 1;
  }
}
