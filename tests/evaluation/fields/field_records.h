// Input: surveys of flights. Output: records in JSON, and their tables in Markdown.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/evaluation/fields/field_survey.h"

namespace freelsd {

nlohmann::json RecordOf(const FieldSurvey& survey);

// Of records, in their order.
std::string FieldTables(const nlohmann::json& records);

}  // namespace freelsd
