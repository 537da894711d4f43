// The parts of a flight request that have a form of their own.
#pragma once

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// {stage: {field: value}} over defaults; unknown stages and fields are refused. Not yet checked.
PipelineOptions ParseOptions(const nlohmann::json& object, const std::string& pointer);
// The same form, every field written.
nlohmann::json OptionsValuesJson(const PipelineOptions& options);

// `source` ("exif") is only understood in what we stored ourselves.
enum class CameraOrigin { kClient, kStored };
Camera ParseCamera(const nlohmann::json& object, const std::string& pointer, CameraOrigin origin);

Rigid3d ParseRigid3(const nlohmann::json& object, const std::string& pointer);
nlohmann::json Rigid3Json(const Rigid3d& a_from_b);

}  // namespace freelsd
