#include "server/http/digest.h"

#include <algorithm>
#include <optional>

#include "api/api.h"

namespace freelsd {
namespace {

constexpr size_t kSha256Bytes = 32;

std::optional<std::string> HexFromBase64(const std::string& text) {
  constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  constexpr char kHexDigits[] = "0123456789abcdef";
  const std::string alphabet = kAlphabet;
  std::string hex;
  unsigned buffer = 0;
  int num_bits = 0;
  for (const char c : text.substr(0, text.find('='))) {
    const size_t value = alphabet.find(c);
    if (value == std::string::npos) return std::nullopt;
    buffer = (buffer << 6 | static_cast<unsigned>(value)) & 0xffff;
    num_bits += 6;
    if (num_bits < 8) continue;
    num_bits -= 8;
    const unsigned byte = buffer >> num_bits & 0xff;
    hex += {kHexDigits[byte >> 4], kHexDigits[byte & 15]};
  }
  if (hex.size() != 2 * kSha256Bytes) return std::nullopt;
  return hex;
}

}  // namespace

void CheckDigest(const std::string& header, const std::vector<std::string>& accepted_sha256) {
  const std::string key = "sha-256=:";
  const size_t begin = header.find(key);
  if (begin == std::string::npos) return;
  const size_t end = header.find(':', begin + key.size());
  const std::optional<std::string> sha256 =
      end == std::string::npos
          ? std::nullopt
          : HexFromBase64(header.substr(begin + key.size(), end - begin - key.size()));
  if (!sha256) throw ApiError("InvalidRequest", "Repr-Digest: must have the form sha-256=:base64:");
  if (std::find(accepted_sha256.begin(), accepted_sha256.end(), *sha256) == accepted_sha256.end()) {
    throw ApiError("DigestMismatch", "the body's SHA-256 differs from Repr-Digest");
  }
}

}  // namespace freelsd
