// Values of statements in PostgreSQL's binary form.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <libpq-fe.h>

#include "storage/database.h"

namespace freelsd {

// A value and its type. Nothing: NULL.
struct PostgresParameter {
  Oid type;
  std::optional<std::string> bytes;
};

PostgresParameter ParameterOf(const Value& value);
PostgresParameter ParameterOf(const std::vector<int64_t>& values);
PostgresParameter ParameterOf(const std::vector<double>& values);
PostgresParameter ParameterOf(const std::vector<std::string>& values);

// An integer of 1, 2, 4 or 8 bytes (a bool has one), and a double.
int64_t IntegerIn(std::string_view bytes);
double RealIn(std::string_view bytes);

}  // namespace freelsd
