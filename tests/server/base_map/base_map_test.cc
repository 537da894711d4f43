// Settings of the base map: what is refused at the start, and what the page may load from
// elsewhere.
#include "server/base_map/base_map.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/server/test_server.h"
#include "tests/storage/mbtiles_file.h"

namespace freelsd {
namespace {

TEST_CASE("base map: a template has one origin, in lower case and without its path") {
  CHECK(OriginOfTemplate("https://tiles.example.org/{z}/{x}/{y}.png") ==
        "https://tiles.example.org");
  CHECK(OriginOfTemplate("HTTP://Maps.Local:8081/a?k=1&z={z}&y={y}&x={x}") ==
        "http://maps.local:8081");
}

TEST_CASE("base map: a template that is none is refused by the name of the setting") {
  for (const char* const url : {"tiles.example.org/{z}/{x}/{y}",
                                "ftp://tiles.example.org/{z}/{x}/{y}",
                                "javascript://tiles.example.org/{z}/{x}/{y}",
                                "https:///{z}/{x}/{y}",
                                "https://{s}.example.org/{z}/{x}/{y}",
                                "https://*.example.org/{z}/{x}/{y}",
                                "https://*/{z}/{x}/{y}",
                                "https://user:word@example.org/{z}/{x}/{y}",
                                "https://example.org:0/{z}/{x}/{y}",
                                "https://example.org:99999/{z}/{x}/{y}",
                                "https://example.org:/{z}/{x}/{y}",
                                "https://[::1]/{z}/{x}/{y}",
                                "https://example.org;script-src *;/{z}/{x}/{y}",
                                "https://a.org https://b.org/{z}/{x}/{y}",
                                "https://example.org/{z}/{x}",
                                "https://example.org/{z}/{x}/{-y}",
                                "https://example.org/{z}/{x}/{y}{r}.png",
                                "https://example.org/{z}/{x}/{y}/{z}",
                                "https://example.org?{z}/{x}/{y}",
                                "https://{z}{x}{y}",
                                "https://example.org/\r\nX: {z}/{x}/{y}",
                                "https://example.org/'\"{z}/{x}/{y}"}) {
    INFO(url);
    Config config;
    config.base_map_url = url;
    CHECK_THROWS_WITH_AS(BaseMap{config}, doctest::Contains("base_map_url"), ConfigError);
  }
}

TEST_CASE("base map: settings that do not belong together are refused") {
  Config config;
  CHECK(BaseMap(config).TileJson().is_null());
  config.base_map_attribution = "the survey";
  CHECK_THROWS_WITH_AS(BaseMap{config}, doctest::Contains("base_map_attribution"), ConfigError);
  config = {};
  config.base_map_max_zoom = 17;
  CHECK_THROWS_WITH_AS(BaseMap{config}, doctest::Contains("base_map_max_zoom"), ConfigError);
  config.base_map_url = "https://example.org/{z}/{x}/{y}";
  CHECK(BaseMap(config).TileJson()["maxzoom"] == 17);
  config.base_map_max_zoom = 25;
  CHECK_THROWS_WITH_AS(BaseMap{config}, doctest::Contains("base_map_max_zoom"), ConfigError);
  config.base_map_max_zoom.reset();
  config.base_map_file = "/map.mbtiles";
  CHECK_THROWS_WITH_AS(BaseMap{config}, doctest::Contains("only one"), ConfigError);
  config.base_map_url.clear();
  CHECK(BaseMap(config).problem().find("there is no such file") != std::string::npos);
}

TEST_CASE("base map: an attribution keeps its words and loses its markup") {
  CHECK(WithoutMarkup("&copy; <a href=\"https://osm.org\">OpenStreetMap</a> contributors") ==
        "\u00a9 OpenStreetMap contributors");
  CHECK(WithoutMarkup("<img src=x onerror=alert(1)>a > b &amp; c") == "a  b & c");
  CHECK(WithoutMarkup("a<<b>script>c</script").find_first_of("<>") == std::string::npos);
}

TEST_CASE("base map: a server starts without a file of vector tiles, and says why") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "map.mbtiles";
  MbTilesFile(file).SetMetadata("format", "pbf");
  Config config = TestConfig(folder.path() / "data");
  config.base_map_file = file;
  const BaseMap map(config);
  CHECK(map.TileJson().is_null());
  CHECK(map.problem().find("vector tiles") != std::string::npos);
  CHECK_NOTHROW(App{config});
}

}  // namespace
}  // namespace freelsd
