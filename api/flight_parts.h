// Parts of a flight request that have their own JSON form.
#pragma once

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// Reads {preset: name, stage: {field: value}} over the preset or the defaults, and refuses unknown
// names. No Check() is called.
PipelineOptions ParseOptions(const nlohmann::json& object, const std::string& pointer);
// Throws ApiError RetiredOption if the object sets a field that requests cannot set.
void RefuseRetiredOptions(const nlohmann::json& object, const std::string& pointer);
// The same options without those that this program does not have: another version stored them.
nlohmann::json WithoutUnknownOptions(const nlohmann::json& object);
// Writes the same form with every field. Withheld is terrain.height_fusion: the preset decides it.
nlohmann::json OptionsValuesJson(const PipelineOptions& options);

// Of a flight that is given none: an experiment if the preset, or an option that can change a
// verdict, differs from its default.
FlightMemory DefaultMemory(const FlightRequest& request);

// The key `source` ("exif") is accepted in stored JSON only, not from clients.
enum class CameraOrigin { kClient, kStored };
Camera ParseCamera(const nlohmann::json& object, const std::string& pointer, CameraOrigin origin);

Rigid3d ParseRigid3(const nlohmann::json& object, const std::string& pointer);
nlohmann::json Rigid3Json(const Rigid3d& a_from_b);

}  // namespace freelsd
