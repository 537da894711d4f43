// Bytes within JSON (RFC 4648).
#pragma once

#include <optional>
#include <string>

namespace freelsd {

std::string Base64Of(const std::string& bytes);
// Nothing if the text is no base64.
std::optional<std::string> BytesOfBase64(const std::string& text);

}  // namespace freelsd
