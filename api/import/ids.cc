#include <array>
#include <memory>
#include <stdexcept>

#include <openssl/evp.h>

#include "api/import/import.h"
#include "api/limits.h"

namespace freelsd {
namespace {

constexpr size_t kMaxShownBytes = 80;

bool IsIdCharacter(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

// True for every byte of a UTF-8 character except the first.
bool IsContinuationByte(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

}  // namespace

bool IsValidId(std::string_view id) {
  if (id.empty() || id.size() > kLimits.max_id_bytes || id == "." || id == "..") return false;
  for (const char c : id) {
    if (!IsIdCharacter(c)) return false;
  }
  return true;
}

std::string IdFromFileName(std::string_view file_name) {
  const size_t folder = file_name.find_last_of("/\\");
  if (folder != std::string_view::npos) file_name.remove_prefix(folder + 1);
  std::string id;
  for (const char c : file_name) {
    if (IsIdCharacter(c)) {
      id += c;
    } else if (!IsContinuationByte(c)) {
      id += '_';
    }
  }
  if (id.size() > kLimits.max_id_bytes) id.resize(kLimits.max_id_bytes);
  if (id.empty() || id == ".") return "_";
  return id == ".." ? "__" : id;
}

std::string IdFromPath(std::string_view path) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string id;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    if (IsIdCharacter(c)) {
      id += c;
    } else if (c == '/' || c == '\\') {
      id += '_';
    } else {
      id += {'-', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  // Names differ at their ends.
  if (id.size() > kLimits.max_id_bytes) id.erase(0, id.size() - kLimits.max_id_bytes);
  return IsValidId(id) ? id : IdFromFileName(path);
}

std::string ShownPath(const std::string& path) {
  std::string shown = path.substr(0, kMaxShownBytes);
  for (char& c : shown) c = c < ' ' || c > '~' ? '_' : c;
  return shown;
}

std::string Sha256Hex(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available");
  }
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (unsigned int i = 0; i < size; ++i) {
    hex += kDigits[digest[i] >> 4];
    hex += kDigits[digest[i] & 15];
  }
  return hex;
}

}  // namespace freelsd
