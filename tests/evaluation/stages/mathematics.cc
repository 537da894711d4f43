#include "tests/evaluation/stages/mathematics.h"

#include <cmath>
#include <cstdint>
#include <random>

namespace freelsd {
namespace {

struct Function {
  const char* name;
  double from;
  double to;
  double (*value_at)(double argument);
};

float AsFloat(double argument) { return static_cast<float>(argument); }

// Domains are those that the engine uses.
constexpr Function kFunctions[] = {
    {"sin", -7.0, 7.0, [](double x) { return std::sin(x); }},
    {"cos", -7.0, 7.0, [](double x) { return std::cos(x); }},
    {"tan", -1.5, 1.5, [](double x) { return std::tan(x); }},
    {"asin", -1.0, 1.0, [](double x) { return std::asin(x); }},
    {"acos", -1.0, 1.0, [](double x) { return std::acos(x); }},
    {"atan", -9.0, 9.0, [](double x) { return std::atan(x); }},
    {"atan2", -9.0, 9.0, [](double x) { return std::atan2(x, 1.0 + 0.3 * x * x); }},
    {"sinh", -5.0, 5.0, [](double x) { return std::sinh(x); }},
    {"exp", -30.0, 5.0, [](double x) { return std::exp(x); }},
    {"exp2", -30.0, 5.0, [](double x) { return std::exp2(x); }},
    {"log", 1e-6, 9.0, [](double x) { return std::log(x); }},
    {"log2", 1e-6, 9.0, [](double x) { return std::log2(x); }},
    {"log10", 1e-6, 9.0, [](double x) { return std::log10(x); }},
    {"pow", 1e-6, 9.0, [](double x) { return std::pow(x, 0.37 + x); }},
    {"sqrt", 0.0, 9.0, [](double x) { return std::sqrt(x); }},
    {"cbrt", -9.0, 9.0, [](double x) { return std::cbrt(x); }},
    {"hypot", -99.0, 99.0, [](double x) { return std::hypot(x, 3.3); }},
    {"erfc", -3.0, 6.0, [](double x) { return std::erfc(x); }},
    {"fmod", -99.0, 99.0, [](double x) { return std::fmod(x, 0.77); }},
    {"logf", 1e-6, 9.0, [](double x) { return double{std::log(AsFloat(x))}; }},
    {"expf", -30.0, 5.0, [](double x) { return double{std::exp(AsFloat(x))}; }},
    {"tanf", -1.5, 1.5, [](double x) { return double{std::tan(AsFloat(x))}; }},
};

// Uniform; the standard's own distribution may differ from library to library.
double UniformArgument(const Function& function, std::mt19937_64& random) {
  const double share = static_cast<double>(random() >> 11) * 0x1p-53;
  return function.from + (function.to - function.from) * share;
}

}  // namespace

StageRecords RunMathematics(int num_arguments) {
  StageRecords records;
  for (const Function& function : kFunctions) {
    std::mt19937_64 random(7);
    StageRecord record{"mathematics", function.name, {}};
    for (int i = 0; i < num_arguments; ++i) {
      record.values.push_back(function.value_at(UniformArgument(function, random)));
    }
    records.push_back(record);
  }
  return records;
}

}  // namespace freelsd
