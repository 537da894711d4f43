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

std::string UnitOf(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kUnits[] = {{"_m", "m"},
                                                                      {"_m2", "m2"},
                                                                      {"_px", "px"},
                                                                      {"_s", "s"},
                                                                      {"_deg", "deg"},
                                                                      {"_mps", "m/s"},
                                                                      {"_ratio", "ratio"},
                                                                      {"_percent", "percent"},
                                                                      {"_ms", "ms"},
                                                                      {"_frames", "frames"}};
  for (const auto& [suffix, unit] : kUnits) {
    if (name.size() > suffix.size() && name.substr(name.size() - suffix.size()) == suffix) {
      return std::string(unit);
    }
  }
  return "";
}

// The options that the given ones are read over: those of the preset, or the defaults.
PipelineOptions StartOf(ObjectReader& given) {
  const nlohmann::json* const preset = given.Find("preset");
  if (preset == nullptr) return {};
  ReadEnum<Preset>(*preset, given.PointerTo("preset"));  // refuses all but the paper
  return PaperOptions();
}

// Those that decide only when, where, how fast or with how many words the engine looks. All others
// can change a verdict.
constexpr std::string_view kChangesNoVerdict[] = {"backend_period_frames",
                                                  "max_num_map_sites",
                                                  "map_site_extent_m",
                                                  "max_num_rejections",
                                                  "num_backend_candidates",
                                                  "num_threads"};

bool ChangesVerdicts(std::string_view option) {
  return std::find(std::begin(kChangesNoVerdict), std::end(kChangesNoVerdict), option) ==
         std::end(kChangesNoVerdict);
}

nlohmann::json DescribedOptions(const PipelineOptions& defaults) {
  nlohmann::json described = nlohmann::json::object();
  VisitStages(defaults, [&described](const char* stage, const auto& stage_options) {
    nlohmann::json& fields = described[stage];
    VisitFields(stage_options, [&fields](const char* name, const auto& field, const char* help) {
      fields[name] = {{"default", Written(field)},
                      {"unit", UnitOf(name)},
                      {"help", help},
                      {"changes_verdicts", ChangesVerdicts(name)}};
    });
  });
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
    VisitFields(stage_options, [&fields](const char* name, auto& field, const char*) {
      const nlohmann::json* const value = fields.Find(name);
      if (value == nullptr) return;
      field = Read<std::remove_reference_t<decltype(field)>>(*value, fields.PointerTo(name));
    });
    fields.RefuseUnknownKeys();
  });
  stages.RefuseUnknownKeys();
  return options;
}

nlohmann::json OptionsValuesJson(const PipelineOptions& options) {
  nlohmann::json values = nlohmann::json::object();
  if (options.preset != Preset::kNone) values["preset"] = Written(options.preset);
  VisitStages(options, [&values](const char* stage, const auto& stage_options) {
    nlohmann::json& fields = values[stage];
    VisitFields(stage_options, [&fields](const char* name, const auto& field, const char*) {
      fields[name] = Written(field);
    });
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
      if (!ChangesVerdicts(name)) continue;
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
  return {{"options", DescribedOptions(PipelineOptions{})}, {"aircraft_profiles", profiles}};
}

}  // namespace freelsd
