// freelsd-judge-tracks: surveys a mosaic of seeded worlds, writes its true surface for the
// simulator that flies over it, and tells what the tracks of those flights met.
//
// The file of tracks: {"tracks": [{"id", "touchdown": {latitude_deg, longitude_deg},
// "touchdown_uncertainty_m", "heading_deg",
// "points": [[time_s, latitude_deg, longitude_deg, altitude_m], ...]}]}.
#include <exception>
#include <fstream>
#include <iostream>
#include <sstream>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "tests/evaluation/flown/flown_track.h"
#include "tests/evaluation/flown/height_grid.h"
#include "tests/evaluation/flown/stored_flight.h"

namespace freelsd {
namespace {

struct Arguments {
  int side = 6;
  uint64_t seed = 57000;
  std::string aircraft = "small";
  std::string survey;
  std::string heights;
  double cell_size_m = 1.0;
  std::string tracks;
};

FlownTrack TrackOf(const nlohmann::json& given) {
  FlownTrack track;
  track.id = given.at("id");
  track.touchdown = {
      given.at("touchdown").at("latitude_deg"), given.at("touchdown").at("longitude_deg"), 0.0};
  track.touchdown_uncertainty_m = given.at("touchdown_uncertainty_m");
  track.heading = RadFromDeg(given.at("heading_deg").get<double>());
  for (const nlohmann::json& point : given.at("points")) {
    track.points.push_back({point.at(0), {point.at(1), point.at(2), point.at(3)}});
  }
  return track;
}

nlohmann::json JsonOf(const FlownTrack& track, const TrackVerdict& verdict) {
  return {{"id", track.id},
          {"is_landing", verdict.IsLanding()},
          {"has_contact", verdict.has_contact},
          {"hit", verdict.hit},
          {"roll_fault", verdict.roll_fault},
          {"is_thin", verdict.is_thin},
          {"is_in_disc", verdict.is_in_disc},
          {"time_s", verdict.time_s},
          {"latitude_deg", verdict.place.latitude_deg},
          {"longitude_deg", verdict.place.longitude_deg},
          {"altitude_m", verdict.place.altitude_m},
          {"along_m", verdict.along_m},
          {"across_m", verdict.across_m},
          {"ground_speed_mps", verdict.ground_speed_mps},
          {"roll_m", verdict.roll_m}};
}

nlohmann::json ReadTracks(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  return nlohmann::json::parse(file).at("tracks");
}

void Run(const Arguments& arguments) {
  if (!arguments.survey.empty()) {
    for (int i = 0; i < arguments.side * arguments.side; ++i) {
      ScenarioOptions options;
      options.aircraft = arguments.aircraft;
      StoreOverHttp(arguments.survey, MakeMosaicPart(arguments.seed, arguments.side, i, options));
    }
    return;
  }
  const std::optional<Aircraft> aircraft = AircraftProfile(arguments.aircraft);
  if (!aircraft) throw std::invalid_argument("no such aircraft: " + arguments.aircraft);
  const nlohmann::json tracks =
      arguments.tracks.empty() ? nlohmann::json::array() : ReadTracks(arguments.tracks);
  const Mosaic mosaic = MakeMosaic(arguments.seed, arguments.side);
  if (!arguments.heights.empty()) {
    WriteHeightGrid(mosaic, arguments.cell_size_m, arguments.heights);
  }
  TrackJudge judge(mosaic, *aircraft);
  nlohmann::json verdicts = nlohmann::json::array();
  for (const nlohmann::json& given : tracks) {
    // No place was told: nothing to judge.
    if (!given.contains("touchdown")) continue;
    const FlownTrack track = TrackOf(given);
    verdicts.push_back(JsonOf(track, judge.Judge(track)));
  }
  if (!arguments.tracks.empty()) std::cout << nlohmann::json{{"verdicts", verdicts}}.dump() << "\n";
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    freelsd::Arguments arguments;
    CLI::App app("Judges tracks that were flown over a mosaic of seeded worlds");
    app.add_option("--side", arguments.side, "worlds along one side")->check(CLI::Range(1, 10));
    app.add_option("--seed", arguments.seed, "seed of the mosaic's first world");
    app.add_option("--aircraft",
                   arguments.aircraft,
                   "profile that the sites are for; of a survey also both, by seed");
    app.add_option("--survey", arguments.survey, "only send a flight over each world to this URL");
    app.add_option("--heights", arguments.heights, "write the true surface to this path");
    app.add_option("--cell", arguments.cell_size_m, "cell size of that surface, m")
        ->check(CLI::Range(0.2, 10.0));
    app.add_option("--tracks", arguments.tracks, "judge the tracks of this file");
    CLI11_PARSE(app, argc, argv);
    freelsd::Run(arguments);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "freelsd-judge-tracks: " << error.what() << "\n";
    return 1;
  }
}
