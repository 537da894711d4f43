// Input: surveys of flights. Output: records in JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "tests/evaluation/fields/field_survey.h"

namespace freelsd {

nlohmann::json RecordOf(const FieldSurvey& survey);

}  // namespace freelsd
