// Who may see what: no run mixes the pools.
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

#include <doctest/doctest.h>

#include "tests/evaluation/campaign.h"
#include "tests/evaluation/frames/rendered_pictures.h"
#include "tests/synthetic/texture/texture.h"

namespace freelsd {
namespace {

CampaignOptions Run(uint64_t seed, int num_worlds, const std::string& ground) {
  CampaignOptions options;
  options.seed = seed;
  options.num_worlds = num_worlds;
  options.scenario.ground = ground;
  return options;
}

TEST_CASE("pools: seeds, grounds, flights and places have the pools of the issue") {
  const Pools& pools = EvaluationPools();
  CHECK(pools.OfSeed(8999) == Pool::kTuning);
  CHECK(pools.OfSeed(9000) == std::nullopt);
  CHECK(pools.OfSeed(50000) == Pool::kReport);
  CHECK(pools.Of("ground", "churo_pe") == Pool::kTuning);
  CHECK(pools.Of("ground", "iquitos_pe") == Pool::kReport);
  CHECK(pools.Of("flight", "seneca_nir") == Pool::kReport);
  CHECK(pools.Of("flight", "somebody's own") == std::nullopt);
  CHECK(pools.NamesOf("place", Pool::kReport).size() == 7);
  CHECK(pools.NamesOf("ground", Pool::kReport).size() == 6);
  CHECK(pools.FoldOf("swindale") == 0);
  CHECK(pools.FoldOf("somebody's own") == std::nullopt);
  for (const std::string& place : pools.NamesOf("place", Pool::kReport)) {
    CHECK(std::filesystem::exists(FoldModelOf(place).value()));
  }
}

TEST_CASE("pools: a run that mixes them is refused, and so is a seed of neither") {
  CHECK_NOTHROW(Run(1000, 6, "churo_pe").Check());
  CHECK_NOTHROW(Run(50000, 6, "report").Check());
  CHECK_THROWS_WITH_AS(
      Run(1000, 6, "iquitos_pe").Check(),
      "ground iquitos_pe is of the pool report, but seed 1000 is of the pool tuning",
      std::invalid_argument);
  CHECK_THROWS_AS(Run(50000, 6, "tuning").Check(), std::invalid_argument);
  CHECK_THROWS_WITH_AS(Run(8998, 6, "").Check(),
                       "seed 9003 is of no pool: see tests/evaluation/pools.csv",
                       std::invalid_argument);
}

TEST_CASE("pools: a table that cannot be read is named with its line") {
  const std::string path = std::filesystem::temp_directory_path() / "freelsd-pools.csv";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return Pools::Read(path);
  };
  CHECK(read("kind,name,pool\nflight,a,tuning\n").Of("flight", "a") == Pool::kTuning);
  CHECK_THROWS_AS(read("flight,a,training\n"), std::runtime_error);
  CHECK_THROWS_AS(read("seeds,5,tuning\n"), std::runtime_error);
  CHECK_THROWS_AS(read("fold,a,5\n"), std::runtime_error);
  CHECK_THROWS_AS(read("flight,a,tuning\nflight,a,report\n"), std::runtime_error);
  std::filesystem::remove(path);
  CHECK_THROWS_AS(Pools::Read(path), std::runtime_error);
}

TEST_CASE("pools: rendered frames cannot be of a seed of the other pool") {
  PoolOfRun run;
  run.Add("place snowpeak_ebee", Pool::kReport);
  const WorldLook look = WorldLooks(Pool::kReport, 3).front();
  CHECK_THROWS_WITH_AS(RenderPictures(0, look, run),
                       doctest::Contains("seed 0 is of the pool tuning"),
                       std::invalid_argument);
}

TEST_CASE("pools: no photograph is worn by both, and places split by photograph say so") {
  std::map<std::string, std::string> pool_of_photograph;
  std::map<std::string, std::set<std::string>> pools_of_place;
  const auto place_of = [](const std::string& path) { return path.substr(0, path.rfind('/')); };
  for (const TextureSource& source : ReadTextureSources()) {
    const auto [entry, is_new] = pool_of_photograph.try_emplace(source.photograph, source.pool);
    CHECK_MESSAGE(entry->second == source.pool, source.photograph);
    pools_of_place[place_of(source.photograph)].insert(source.pool);
  }
  for (const TextureSource& source : ReadTextureSources()) {
    const bool is_split = pools_of_place.at(place_of(source.photograph)).size() > 1;
    CHECK_MESSAGE(is_split == (source.split == "photograph"), source.photograph);
  }
}

}  // namespace
}  // namespace freelsd
