// freelsd-frames: rendered frames beside labelled photographs, cover by cover. Prints tables in
// Markdown.
#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/evaluation/campaign.h"
#include "tests/evaluation/frames/comparison.h"
#include "tests/evaluation/frames/recorded_pictures.h"
#include "tests/evaluation/frames/rendered_pictures.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

struct Arguments {
  std::string pool = "tuning";
  // Of the first world of each kind; the pool's first seed if not given.
  std::optional<uint64_t> seed;
  int num_worlds = 4;
  // Real ground has windows in turns; with six, four worlds lie on four packs or windows.
  uint64_t seed_step = 6;
  int num_frames = 4;
  double lens_blur_px = 0.5;
  // Only these kinds of world; all if empty.
  std::vector<std::string> looks;
  // In place of those of each kind.
  std::optional<double> cell_size_m;
  std::string conditions;
  int num_jobs = 1;
  TileOptions tiles;
  std::string json;
  // Folder for all rendered frames and their covers; none if empty.
  std::string pictures;
};

uint64_t FirstSeed(const Arguments& arguments, Pool pool) {
  constexpr uint64_t kFirstTuningSeed = 0;
  constexpr uint64_t kFirstReportSeed = 50000;
  return arguments.seed.value_or(pool == Pool::kTuning ? kFirstTuningSeed : kFirstReportSeed);
}

std::vector<WorldLook> LooksFor(const Arguments& arguments, Pool pool) {
  std::vector<WorldLook> looks;
  for (WorldLook& look : WorldLooks(pool, arguments.num_frames)) {
    const auto& wanted = arguments.looks;
    const bool is_wanted =
        wanted.empty() || std::find(wanted.begin(), wanted.end(), look.name) != wanted.end();
    if (!is_wanted) continue;
    if (arguments.cell_size_m) look.scenario.cell_size_m = *arguments.cell_size_m;
    if (!arguments.conditions.empty()) look.scenario.conditions = arguments.conditions;
    looks.push_back(std::move(look));
  }
  return looks;
}

// Photographs first, then worlds; all at the scale of the comparison.
std::vector<LabelledPicture> ReadAndRender(const Arguments& arguments, Pool pool) {
  const double ground_sampling_m = arguments.tiles.ground_sampling_m;
  PoolOfRun run;
  std::vector<LabelledPicture> pictures;
  for (LabelledPicture& picture : ReadRecordedPictures(pool, ground_sampling_m, run)) {
    pictures.push_back(Blurred(std::move(picture), arguments.lens_blur_px));
  }
  for (const WorldLook& look : LooksFor(arguments, pool)) {
    for (int i = 0; i < arguments.num_worlds; ++i) {
      const uint64_t seed =
          FirstSeed(arguments, pool) + static_cast<uint64_t>(i) * arguments.seed_step;
      for (const LabelledPicture& picture : RenderPictures(seed, look, run)) {
        const auto scaled = AtScale(picture, ground_sampling_m);
        std::cerr << picture.name << ": " << picture.ground_sampling_m << " m per pixel"
                  << (scaled ? "\n" : ", too coarse to compare\n");
        if (scaled) pictures.push_back(*scaled);
      }
    }
  }
  return pictures;
}

TilesOfLooks Measured(const std::vector<LabelledPicture>& pictures, const Arguments& arguments) {
  TilesOfLooks tiles;
  for (const LabelledPicture& picture : pictures) {
    for (const auto& [cover, measures] : MeasureTiles(picture, arguments.tiles)) {
      LookTiles& of_look = tiles[cover][picture.look];
      of_look.measures.insert(of_look.measures.end(), measures.begin(), measures.end());
      ++of_look.num_pictures;
    }
  }
  return tiles;
}

// NAME.png and, as an 8-bit image of Cover, NAME_cover.png; at the scale of the comparison.
void WriteRendered(const std::vector<LabelledPicture>& pictures, const std::string& folder) {
  std::filesystem::create_directories(folder);
  for (const LabelledPicture& picture : pictures) {
    if (picture.look == kRecorded) continue;
    const std::string path = folder + "/" + picture.name;
    if (!cv::imwrite(path + ".png", picture.image) ||
        !cv::imwrite(path + "_cover.png", picture.cover)) {
      throw std::runtime_error("cannot write " + path);
    }
  }
}

void Run(const Arguments& arguments) {
  arguments.tiles.Check();
  cv::setNumThreads(arguments.num_jobs);
  const Pool pool = arguments.pool == NameOf(Pool::kReport) ? Pool::kReport : Pool::kTuning;
  const std::vector<LabelledPicture> pictures = ReadAndRender(arguments, pool);
  if (!arguments.pictures.empty()) WriteRendered(pictures, arguments.pictures);
  Json report{{"pool", arguments.pool},
              {"ground_sampling_m", arguments.tiles.ground_sampling_m},
              {"lens_blur_px", arguments.lens_blur_px},
              {"tile_m", arguments.tiles.tile_m},
              {"first_seed", FirstSeed(arguments, pool)},
              {"seed_step", arguments.seed_step},
              {"num_worlds", arguments.num_worlds},
              {"num_frames", arguments.num_frames},
              {"covers", CompareLooks(Measured(pictures, arguments))}};
  if (arguments.cell_size_m) report["cell_size_m"] = *arguments.cell_size_m;
  if (!arguments.conditions.empty()) report["conditions"] = arguments.conditions;
  std::cout << ComparisonAsMarkdown(report);
  if (!arguments.json.empty()) WriteTextFile(arguments.json, report.dump(1) + "\n");
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("--pool", arguments.pool, "photographs, textures, ground and seeds of this pool")
      ->check(CLI::IsMember({"tuning", "report"}));
  app.add_option("--seed", arguments.seed, "seed of the first world of each kind");
  app.add_option("--seed-step", arguments.seed_step, "from one world's seed to the next");
  app.add_option("--worlds", arguments.num_worlds, "worlds of each kind")
      ->check(CLI::Range(1, 1000));
  app.add_option("--frames", arguments.num_frames, "photographs per world")
      ->check(CLI::Range(3, 300));
  app.add_option("--look", arguments.looks, "kinds of world; all if not given")
      ->check(CLI::IsMember({"painted", "textured", "ground"}));
  app.add_option("--cell", arguments.cell_size_m, "metres; 0.1 for textured, else 0.2")
      ->check(CLI::Range(0.1, 1.0));
  app.add_option("--conditions", arguments.conditions, "plain, or as recorded flights show them")
      ->check(CLI::IsMember({"plain", "recorded"}));
  app.add_option("--gsd", arguments.tiles.ground_sampling_m, "metres per pixel of the comparison");
  app.add_option("--lens-blur",
                 arguments.lens_blur_px,
                 "deviation in pixels with which photographs are blurred, as frames are")
      ->check(CLI::Range(0.0, 3.0));
  app.add_option("--tile", arguments.tiles.tile_m, "side of a tile in metres");
  app.add_option("--jobs", arguments.num_jobs, "threads; no result depends on it")
      ->check(CLI::Range(1, 64));
  app.add_option("--json", arguments.json, "the same numbers");
  app.add_option("--pictures", arguments.pictures, "folder for all rendered frames and covers");
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  try {
    CLI::App app{"Compares rendered frames with labelled photographs, cover by cover."};
    freelsd::Arguments arguments;
    freelsd::AddOptions(app, arguments);
    CLI11_PARSE(app, argc, argv);
    freelsd::Run(arguments);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "freelsd-frames: " << error.what() << "\n";
    return 1;
  }
}
