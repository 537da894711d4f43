// Text of unknown encoding -> UTF-8.
#pragma once

#include <string>
#include <string_view>

namespace freelsd {

// Reads UTF-16 with or without a byte order mark (Windows writes it), and removes the mark of
// UTF-8. Any other text is returned as it is. What is no UTF-16 becomes "?".
std::string ToUtf8(std::string_view text);

}  // namespace freelsd
