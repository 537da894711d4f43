// What options say of a value that is out of bounds.
#pragma once

#include <stdexcept>
#include <string>
#include <type_traits>

namespace freelsd {

// The refusal of default options with this value in one field; empty if it is accepted.
template <typename Options, typename Value>
std::string RefusalOf(Value Options::*field, const std::type_identity_t<Value>& value) {
  Options options;
  options.*field = value;
  try {
    options.Check();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// Whether the refusal names the field.
template <typename Options, typename Value>
bool IsRefused(Value Options::*field,
               const std::type_identity_t<Value>& value,
               const std::string& name) {
  return RefusalOf(field, value).find(name) != std::string::npos;
}

}  // namespace freelsd
