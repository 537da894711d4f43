// What an ApiError said, for checks.
#pragma once

#include <functional>
#include <string>

#include <doctest/doctest.h>

#include "api/api.h"

namespace freelsd {

// "422 InvalidValue /camera/fx_px" of what `call` throws; "nothing" when it returns.
inline std::string ErrorOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const ApiError& error) {
    std::string text = std::to_string(error.http_status()) + " " + error.code();
    if (!error.errors().empty()) text += " " + error.errors()[0].pointer;
    return text;
  }
  return "nothing";
}

}  // namespace freelsd
