#include "storage/postgres/parameters.h"

#include <bit>

namespace freelsd {
namespace {

// Numbers of PostgreSQL's own types; they never change.
constexpr Oid kBoolType = 16;
constexpr Oid kByteaType = 17;
constexpr Oid kInt8Type = 20;
constexpr Oid kTextType = 25;
constexpr Oid kFloat8Type = 701;
constexpr Oid kTextArrayType = 1009;
constexpr Oid kInt8ArrayType = 1016;
constexpr Oid kFloat8ArrayType = 1022;

// Most significant byte first.
template <typename Number>
std::string BytesOf(Number number) {
  std::string bytes(sizeof(number), '\0');
  for (size_t i = 0; i < sizeof(number); ++i) {
    bytes[sizeof(number) - 1 - i] = static_cast<char>(static_cast<uint64_t>(number) >> (8 * i));
  }
  return bytes;
}

std::string BytesOf(double number) { return BytesOf(std::bit_cast<int64_t>(number)); }

std::string BytesOf(const std::string& text) { return text; }

// One dimension, no NULLs, the first element is number 1.
template <typename Value>
PostgresParameter ArrayOf(Oid type, Oid element_type, const std::vector<Value>& values) {
  const int32_t num_dimensions = values.empty() ? 0 : 1;
  std::string bytes = BytesOf(num_dimensions) + BytesOf(int32_t{0}) + BytesOf(element_type);
  if (num_dimensions > 0) {
    bytes += BytesOf(static_cast<int32_t>(values.size())) + BytesOf(int32_t{1});
  }
  for (const Value& value : values) {
    const std::string own = BytesOf(value);
    bytes += BytesOf(static_cast<int32_t>(own.size())) + own;
  }
  return {type, std::move(bytes)};
}

struct MakeParameter {
  PostgresParameter operator()(bool value) const {
    return {kBoolType, std::string(1, value ? '\1' : '\0')};
  }
  PostgresParameter operator()(int64_t value) const { return {kInt8Type, BytesOf(value)}; }
  PostgresParameter operator()(double value) const { return {kFloat8Type, BytesOf(value)}; }
  PostgresParameter operator()(const std::optional<int64_t>& value) const {
    return value ? (*this)(*value) : PostgresParameter{kInt8Type, std::nullopt};
  }
  PostgresParameter operator()(const std::optional<double>& value) const {
    return value ? (*this)(*value) : PostgresParameter{kFloat8Type, std::nullopt};
  }
  PostgresParameter operator()(std::string_view value) const {
    return {kTextType, std::string(value)};
  }
  PostgresParameter operator()(const Blob& value) const {
    return {kByteaType, std::string(value.bytes)};
  }
};

}  // namespace

PostgresParameter ParameterOf(const Value& value) { return std::visit(MakeParameter(), value); }

PostgresParameter ParameterOf(const std::vector<int64_t>& values) {
  return ArrayOf(kInt8ArrayType, kInt8Type, values);
}

PostgresParameter ParameterOf(const std::vector<double>& values) {
  return ArrayOf(kFloat8ArrayType, kFloat8Type, values);
}

PostgresParameter ParameterOf(const std::vector<std::string>& values) {
  return ArrayOf(kTextArrayType, kTextType, values);
}

int64_t IntegerIn(std::string_view bytes) {
  if (bytes.empty()) return 0;
  const bool is_negative = (static_cast<unsigned char>(bytes.front()) & 0x80U) != 0;
  uint64_t number = is_negative ? ~uint64_t{0} : 0;
  for (const char byte : bytes) number = number << 8U | static_cast<unsigned char>(byte);
  return static_cast<int64_t>(number);
}

double RealIn(std::string_view bytes) { return std::bit_cast<double>(IntegerIn(bytes)); }

}  // namespace freelsd
