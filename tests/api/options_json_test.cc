#include <tuple>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/flight_parts.h"
#include "api/options_table.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

// Anything a field can be initialised from: counts the fields of an aggregate.
struct Anything {
  template <class T>
  operator T() const;  // NOLINT(google-explicit-constructor)
};

template <class Aggregate, size_t... I>
constexpr bool TakesThisMany(std::index_sequence<I...>) {
  return requires { Aggregate{(static_cast<void>(I), Anything{})...}; };
}

template <class Aggregate, size_t N = 64>
constexpr size_t NumFields() {
  if constexpr (TakesThisMany<Aggregate>(std::make_index_sequence<N>())) {
    return N;
  } else {
    return NumFields<Aggregate, N - 1>();
  }
}

// Of all parts of a section.
template <class Options>
size_t NumFieldsOf(const Options&) {
  return NumFields<Options>();
}
template <class... Parts>
size_t NumFieldsOf(const std::tuple<Parts&...>&) {
  return (NumFields<std::decay_t<Parts>>() + ...);
}

TEST_CASE("options: the table has every field of every stage") {
  const PipelineOptions options;
  size_t num_stages = 0;
  VisitStages(options, [&num_stages](const char* stage, const auto& stage_options) {
    ++num_stages;
    size_t num_fields = 0;
    VisitFields(stage_options, [&num_fields](const char*, const auto&) { ++num_fields; });
    CAPTURE(std::string(stage));
    // terrain.height_fusion is to compare with, and nothing to land by: only the preset sets it.
    size_t num_withheld = std::string(stage) == "terrain" ? 1 : 0;
    // adjustment.function_tolerance is for evaluations.
    if (std::string(stage) == "adjustment") num_withheld = 1;
    // CoverOptions holds the photo's and the clear class's, which are in other sections.
    if (std::string(stage) == "hazard") num_withheld = 2;
    // ApproachOptions holds those of the risk, which are counted besides.
    if (std::string(stage) == "approach") num_withheld = 1;
    CHECK(num_fields + num_withheld == NumFieldsOf(stage_options));
  });
  const size_t num_presets = 1;
  CHECK(num_stages + num_presets == NumFields<PipelineOptions>());
}

TEST_CASE("options: written and read again nothing is lost") {
  PipelineOptions options;
  options.tracks.assume_ground_plane = true;
  options.hazard.cover.grass_fusion = GrassFusion::kPaperOr;
  options.segmentation.paper_canny_coefficients = {1, 2, 3, 4};
  options.approach.start_height_ratios = {1.0, 1.25};
  options.stereo.block_size_px = 5;
  const nlohmann::json written = OptionsValuesJson(options);
  CHECK(OptionsValuesJson(ParseOptions(written, "/options")) == written);
  CHECK(written["hazard"]["grass_fusion"] == "paper");
}

TEST_CASE("options: the preset is the published form, and fields beside it override it") {
  const PipelineOptions paper =
      ParseOptions(nlohmann::json::parse(R"({"preset": "paper"})"), "/options");
  CHECK(paper.preset == Preset::kPaper);
  CHECK(paper.terrain.height_fusion == HeightFusion::kPaperMean);
  CHECK(OptionsValuesJson(paper) == OptionsValuesJson(PaperOptions()));
  CHECK(OptionsValuesJson(paper)["preset"] == "paper");
  CHECK_NOTHROW(CheckOptions(paper));
  const PipelineOptions changed = ParseOptions(
      nlohmann::json::parse(R"({"preset": "paper", "stereo": {"num_partners": 3}})"), "/options");
  CHECK(changed.stereo.num_partners == 3);
  CHECK(changed.approach.start_height_ratios == std::vector<double>{1.0});
  // Stored and read again, also the field that JSON does not hold.
  const PipelineOptions stored = ParseOptions(OptionsValuesJson(changed), "/options");
  CHECK(OptionsValuesJson(stored) == OptionsValuesJson(changed));
  CHECK(stored.terrain.height_fusion == HeightFusion::kPaperMean);
  CHECK_FALSE(OptionsValuesJson(PipelineOptions{}).contains("preset"));
}

TEST_CASE("options: what is wrong is refused where it is") {
  const auto error_of = [](const char* text) {
    return ErrorOf([text] { ParseOptions(nlohmann::json::parse(text), "/options"); });
  };
  CHECK(error_of("{}") == "nothing");
  CHECK(error_of(R"({"wind": null})") == "nothing");
  CHECK(error_of(R"({"preset": null})") == "nothing");
  CHECK(error_of(R"({"preset": "magic"})") == "422 InvalidValue /options/preset");
  CHECK(error_of(R"({"preset": 1})") == "422 InvalidValue /options/preset");
  CHECK(error_of(R"({"preset": "paper", "wind": {"radius": 1}})") ==
        "422 UnknownKey /options/wind/radius");
  CHECK(error_of(R"({"magic": {}})") == "422 UnknownKey /options/magic");
  CHECK(error_of(R"({"wind": {"radius": 1}})") == "422 UnknownKey /options/wind/radius");
  CHECK(error_of(R"({"wind": {"radius_m": "1"}})") == "422 InvalidValue /options/wind/radius_m");
  CHECK(error_of(R"({"stereo": {"block_size_px": 5.5}})") ==
        "422 InvalidValue /options/stereo/block_size_px");
  CHECK(error_of(R"({"stereo": {"block_size_px": 4294967299}})") ==
        "422 InvalidValue /options/stereo/block_size_px");
  CHECK(error_of(R"({"tracks": {"assume_ground_plane": 1}})") ==
        "422 InvalidValue /options/tracks/assume_ground_plane");
  CHECK(error_of(R"({"hazard": {"slope_support": "sphere"}})") ==
        "422 InvalidValue /options/hazard/slope_support");
  CHECK(error_of(R"({"segmentation": {"paper_canny_coefficients": [1, 2]}})") ==
        "422 InvalidValue /options/segmentation/paper_canny_coefficients");
}

TEST_CASE("options: few are described, with default, unit and reason, as the contract does") {
  nlohmann::json described = OptionsJson();
  const nlohmann::json& field = described["options"]["segmentation"]["ground_sampling_distance_m"];
  CHECK(field["default"] == 0.6);
  CHECK(field["unit"] == "m");
  CHECK(described["options"]["preset"]["changes_verdicts"] == true);
  described["options"].erase("preset");
  const auto contract = nlohmann::json::parse(OpenApiJson());
  const nlohmann::json& schemas = contract["components"]["schemas"]["Options"]["properties"];
  CHECK(schemas.size() == described["options"].size() + 1);
  for (const auto& [stage, fields] : described["options"].items()) {
    const nlohmann::json& schema = schemas.at(stage).at("properties");
    CHECK(schema.size() == fields.size());
    for (const auto& field_of_stage : fields.items()) {
      const std::string& name = field_of_stage.key();
      const nlohmann::json& option = field_of_stage.value();
      CAPTURE(name);
      CHECK(schema.at(name).at("default") == option["default"]);
      const bool changes = option["changes_verdicts"];
      CHECK(schema.at(name).at("description") ==
            option["help"].get<std::string>() +
                (changes ? ". Can change a verdict" : ". Changes no verdict"));
    }
  }
}

TEST_CASE("options: the aircraft profiles stand beside them") {
  const nlohmann::json described = OptionsJson();
  CHECK(described["aircraft_profiles"]["small"]["glide_ratio"] == 7.0);
  CHECK(described["aircraft_profiles"].size() == 3);
}

}  // namespace
}  // namespace freelsd
