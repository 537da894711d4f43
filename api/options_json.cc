#include <algorithm>
#include <array>
#include <climits>
#include <stdexcept>
#include <string>

#include "api/flight_parts.h"
#include "api/json_reader.h"
#include "api/options_table.h"

namespace freelsd {
namespace {

template <class T>
constexpr bool kIsArray = false;
template <size_t N>
constexpr bool kIsArray<std::array<double, N>> = true;

template <class Enum>
Enum ReadEnum(const nlohmann::json& value, const std::string& pointer) {
  const std::string name = ReadString(value, pointer);
  std::string known;
  for (const auto& [each, each_name] : NamesOf(Enum{})) {
    if (each_name == name) return each;
    known += (known.empty() ? "" : ", ") + std::string(each_name);
  }
  throw InvalidValue(pointer, "must be one of " + known);
}

// Reads one field from JSON.
template <class T>
T Read(const nlohmann::json& value, const std::string& pointer) {
  if constexpr (std::is_enum_v<T>) {
    return ReadEnum<T>(value, pointer);
  } else if constexpr (std::is_same_v<T, double>) {
    return ReadNumber(value, pointer, {});
  } else if constexpr (std::is_same_v<T, bool>) {
    return ReadBoolean(value, pointer);
  } else if constexpr (std::is_same_v<T, int>) {
    const int64_t number = ReadInteger(value, pointer);
    ReadNumber(value, pointer, {INT_MIN, INT_MAX});
    return static_cast<int>(number);
  } else if constexpr (kIsArray<T>) {
    T field{};
    const std::vector<double> numbers = ReadNumbers(value, pointer, field.size());
    std::copy(numbers.begin(), numbers.end(), field.begin());
    return field;
  } else {
    return ReadNumbers(value, pointer, std::nullopt);
  }
}

// Writes one field to JSON.
template <class T>
nlohmann::json Written(const T& field) {
  if constexpr (std::is_enum_v<T>) {
    for (const auto& [each, name] : NamesOf(field)) {
      if (each == field) return name;
    }
    throw std::logic_error("an enumerator has no name in options_table.h");
  } else {
    return field;
  }
}

// A field that a request may set, and why somebody would.
struct RequestOption {
  std::string_view stage;
  std::string_view name;
  std::string_view unit;
  std::string_view help;
  bool changes_verdicts;
};

constexpr RequestOption kRequestOptions[] = {
    {"tracks",
     "assume_ground_plane",
     "",
     "Photographs of flat land may overlap too little to measure its height; true takes the ground "
     "as a level plane",
     true},
    {"segmentation",
     "ground_sampling_distance_m",
     "m",
     "A finer sampling of the photographs finds narrower fields, a coarser one is faster",
     true},
    {"adjustment",
     "num_threads",
     "",
     "More threads shorten an evaluation on a machine whose cores are free",
     false},
    {"stereo",
     "ground_sampling_distance_m",
     "m",
     "A finer sampling of the photographs measures smaller things, a coarser one is faster and "
     "needs less memory",
     true},
    {"terrain",
     "cell_size_m",
     "m",
     "Smaller cells of the map show narrower obstacles, larger ones let a slow machine keep up",
     true},
    {"backend",
     "backend_period_frames",
     "frames",
     "Fewer frames between two evaluations give sites earlier in flight, more leave time for the "
     "photographs",
     false},
    {"backend",
     "num_backend_candidates",
     "",
     "A fast machine can evaluate more regions each time",
     false},
    {"backend",
     "max_num_views",
     "",
     "Fewer key-frames in one evaluation need less memory, more let one map show more fields",
     true},
    {"backend",
     "max_num_map_sites",
     "",
     "More sites of one map show more places to land, fewer make a shorter list",
     false}};

constexpr std::string_view kPresetHelp =
    "paper runs every stage in its published form, to be compared with and not to land by";

// Nothing if requests cannot set it.
const RequestOption* FindRequestOption(std::string_view stage, std::string_view name) {
  const auto* const found = std::find_if(
      std::begin(kRequestOptions), std::end(kRequestOptions), [&](const RequestOption& option) {
        return option.stage == stage && option.name == name;
      });
  return found == std::end(kRequestOptions) ? nullptr : found;
}

// What no stage has any more. A section without fields is retired as a whole.
const std::vector<std::pair<std::string, std::vector<std::string>>> kFormerOptions{
    {"hazard",
     {"cover_method",
      "min_rut_contrast",
      "rut_filter_length_m",
      "min_track_length_m",
      "min_working_width_m",
      "max_working_width_m",
      "sprayed_margin_m",
      "max_field_color_deviations",
      "min_overreach_deviations",
      "overreach_surroundings_m",
      "border_ramp_m",
      "max_border_residual_m",
      "min_raised_step_m",
      "min_raised_border_m",
      "min_raised_border_ratio"}},
    {"heights", {}}};

ApiError RetiredOption(const std::string& option, const std::string& pointer) {
  const std::string detail = option + ": is no longer an option of a request";
  return ApiError("RetiredOption", detail, {{pointer, detail}});
}

void RefuseFormerOptions(ObjectReader& stages) {
  for (const auto& [stage, names] : kFormerOptions) {
    const nlohmann::json* const values = stages.Find(stage);
    if (values == nullptr) continue;
    const std::string pointer = stages.PointerTo(stage);
    if (names.empty()) throw RetiredOption(stage, pointer);
    if (!values->is_object()) continue;
    ObjectReader fields(*values, pointer);
    for (const std::string& name : names) {
      if (fields.Find(name) != nullptr) {
        throw RetiredOption(stage + "." + name, fields.PointerTo(name));
      }
    }
  }
}

// The options that the given ones are read over: those of the preset, or the defaults.
PipelineOptions StartOf(ObjectReader& given) {
  const nlohmann::json* const preset = given.Find("preset");
  if (preset == nullptr) return {};
  ReadEnum<Preset>(*preset, given.PointerTo("preset"));  // refuses all but the paper
  return PaperOptions();
}

bool ChangesVerdicts(std::string_view stage, std::string_view name) {
  const RequestOption* const option = FindRequestOption(stage, name);
  return option == nullptr || option->changes_verdicts;
}

nlohmann::json DescribedOptions() {
  const nlohmann::json defaults = OptionsValuesJson(PipelineOptions{});
  nlohmann::json described{
      {"preset",
       {{"default", nullptr}, {"unit", ""}, {"help", kPresetHelp}, {"changes_verdicts", true}}}};
  for (const auto& [stage, name, unit, help, changes_verdicts] : kRequestOptions) {
    described[stage][name] = {{"default", defaults.at(stage).at(name)},
                              {"unit", unit},
                              {"help", help},
                              {"changes_verdicts", changes_verdicts}};
  }
  return described;
}

}  // namespace

PipelineOptions ParseOptions(const nlohmann::json& object, const std::string& pointer) {
  ObjectReader stages(object, pointer);
  PipelineOptions options = StartOf(stages);
  VisitStages(options, [&stages](const char* stage, auto& stage_options) {
    const nlohmann::json* const values = stages.Find(stage);
    if (values == nullptr) return;
    ObjectReader fields(*values, stages.PointerTo(stage));
    VisitFields(stage_options, [&fields](const char* name, auto& field) {
      const nlohmann::json* const value = fields.Find(name);
      if (value == nullptr) return;
      field = Read<std::remove_reference_t<decltype(field)>>(*value, fields.PointerTo(name));
    });
    fields.RefuseUnknownKeys();
  });
  stages.RefuseUnknownKeys();
  return options;
}

void RefuseRetiredOptions(const nlohmann::json& object, const std::string& pointer) {
  if (!object.is_object()) return;
  ObjectReader stages(object, pointer);
  RefuseFormerOptions(stages);
  const PipelineOptions options;
  VisitStages(options, [&](const std::string& stage, const auto& stage_options) {
    const nlohmann::json* const values = stages.Find(stage);
    if (values == nullptr || !values->is_object()) return;
    ObjectReader fields(*values, stages.PointerTo(stage));
    VisitFields(stage_options, [&](const std::string& name, const auto&) {
      if (fields.Find(name) == nullptr || FindRequestOption(stage, name) != nullptr) return;
      throw RetiredOption(stage + "." + name, fields.PointerTo(name));
    });
  });
}

nlohmann::json WithoutUnknownOptions(const nlohmann::json& object) {
  const nlohmann::json known = OptionsValuesJson(PipelineOptions{});
  nlohmann::json kept = nlohmann::json::object();
  if (object.contains("preset")) kept["preset"] = object.at("preset");
  for (const auto& [stage, fields] : known.items()) {
    if (!object.contains(stage)) continue;
    for (const auto& [name, value] : object.at(stage).items()) {
      if (fields.contains(name)) kept[stage][name] = value;
    }
  }
  return kept;
}

nlohmann::json OptionsValuesJson(const PipelineOptions& options) {
  nlohmann::json values = nlohmann::json::object();
  if (options.preset != Preset::kNone) values["preset"] = Written(options.preset);
  VisitStages(options, [&values](const char* stage, const auto& stage_options) {
    nlohmann::json& fields = values[stage];
    VisitFields(stage_options,
                [&fields](const char* name, const auto& field) { fields[name] = Written(field); });
  });
  return values;
}

nlohmann::json GivenOptionsJson(const FlightRequest& request) {
  PipelineOptions start =
      request.options.preset == Preset::kPaper ? PaperOptions() : PipelineOptions{};
  start.regions.min_area_m2 = request.aircraft.min_area_m2;
  const nlohmann::json unchanged = OptionsValuesJson(start);
  const nlohmann::json all = OptionsValuesJson(request.options);
  nlohmann::json given = nlohmann::json::object();
  for (const auto& [stage, values] : all.items()) {
    if (stage == "preset") given[stage] = values;
    if (!values.is_object()) continue;
    for (const auto& [name, value] : values.items()) {
      if (value != unchanged.at(stage).at(name)) given[stage][name] = value;
    }
  }
  return given;
}

FlightMemory DefaultMemory(const FlightRequest& request) {
  const nlohmann::json given = GivenOptionsJson(request);
  if (given.contains("preset")) {
    return {false, "preset " + given["preset"].get<std::string>() + " is an experiment"};
  }
  for (const auto& [stage, fields] : given.items()) {
    for (const auto& [name, value] : fields.items()) {
      if (!ChangesVerdicts(stage, name)) continue;
      return {false, stage + "." + name + " differs from its default and can change a verdict"};
    }
  }
  return {};
}

nlohmann::json OptionsJson() {
  nlohmann::json profiles = nlohmann::json::object();
  for (const std::string& name : AircraftProfileNames()) {
    profiles[name] = AircraftJson(AircraftProfile(name).value());
  }
  return {{"options", DescribedOptions()}, {"aircraft_profiles", profiles}};
}

}  // namespace freelsd
