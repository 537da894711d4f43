#include "engine/check/check.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace freelsd {

FieldCheck::FieldCheck(std::string owner) : owner_(std::move(owner)) {}

void FieldCheck::Inside(const char* field, double value, double min, double max) const {
  std::ostringstream constraint;
  constraint << "must be in [" << min << ", " << max << "]";
  Require(std::isfinite(value) && value >= min && value <= max, field, value, constraint.str());
}

void FieldCheck::Require(bool holds,
                         const char* field,
                         double value,
                         const std::string& constraint) const {
  if (holds) return;
  std::ostringstream message;
  message << owner_ << "." << field << " = " << value << ": " << constraint;
  throw std::invalid_argument(message.str());
}

}  // namespace freelsd
