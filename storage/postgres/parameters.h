// Values of statements in PostgreSQL's binary form.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <libpq-fe.h>

namespace freelsd {

// A value and its type. Nothing: NULL.
struct PostgresParameter {
  Oid type;
  std::optional<std::string> bytes;
};

// Bytes that are bound as bytea, not as text.
struct Bytes {
  std::string_view bytes;
};

PostgresParameter ParameterOf(int64_t value);
PostgresParameter ParameterOf(int value);
PostgresParameter ParameterOf(bool value);
PostgresParameter ParameterOf(double value);
PostgresParameter ParameterOf(const std::optional<int64_t>& value);
PostgresParameter ParameterOf(const std::optional<double>& value);
PostgresParameter ParameterOf(const std::string& value);
PostgresParameter ParameterOf(const Bytes& value);
PostgresParameter ParameterOf(const std::vector<int64_t>& values);
PostgresParameter ParameterOf(const std::vector<double>& values);
PostgresParameter ParameterOf(const std::vector<std::string>& values);
// It would become a bool.
PostgresParameter ParameterOf(const char* value) = delete;

// An integer of 1, 2, 4 or 8 bytes (a bool has one), and a double.
int64_t IntegerIn(std::string_view bytes);
double RealIn(std::string_view bytes);

}  // namespace freelsd
