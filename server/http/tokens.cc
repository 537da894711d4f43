#include "server/http/tokens.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>

#include <nlohmann/json.hpp>
#include <openssl/crypto.h>
#include <sys/stat.h>

#include "api/api.h"
#include "api/import/import.h"
#include "server/config.h"

namespace freelsd {
namespace {

constexpr size_t kSha256HexDigits = 64;
constexpr size_t kMaxTokenBytes = 512;
constexpr mode_t kOthersMayRead = S_IRWXG | S_IRWXO;

Scope ScopeOf(const std::string& name) {
  if (name == "read") return Scope::kRead;
  if (name == "ingest") return Scope::kIngest;
  if (name == "admin") return Scope::kAdmin;
  if (name == "command") return Scope::kCommand;
  throw ConfigError("token file: \"" + name +
                    "\" is not a scope; scopes are read, ingest, admin and command");
}

bool IsHash(const std::string& text) {
  return text.size() == kSha256HexDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

nlohmann::json ReadList(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    throw ConfigError("token file: cannot read " + file.string());
  }
  if ((status.st_mode & kOthersMayRead) != 0) {
    throw ConfigError("token file: others may read " + file.string() + "; its mode must be 0600");
  }
  std::ifstream stream(file, std::ios::binary);
  try {
    return ParseJson(std::string(std::istreambuf_iterator<char>(stream), {}));
  } catch (const ApiError& error) {
    throw ConfigError(std::string("token file: ") + error.what());
  }
}

// The scheme's name is case-insensitive (RFC 9110, 11.1).
bool IsSameScheme(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

}  // namespace

TokenList TokenList::Read(const std::filesystem::path& file) {
  TokenList list;
  list.is_asked_for_ = true;
  const nlohmann::json entries = ReadList(file);
  try {
    for (const nlohmann::json& entry : entries) {
      for (const auto& [key, value] : entry.items()) {
        if (key == "sha256" || key == "scopes") continue;
        throw ConfigError("token file: unknown key " + key +
                          ": a token has sha256 and scopes only, which hold for all flights");
      }
      Token token{entry.at("sha256").get<std::string>(), {}};
      if (!IsHash(token.sha256)) throw ConfigError("token file: sha256 must be 64 hex digits");
      for (const nlohmann::json& scope : entry.at("scopes")) {
        token.scopes.push_back(ScopeOf(scope.get<std::string>()));
      }
      list.tokens_.push_back(std::move(token));
    }
  } catch (const nlohmann::json::exception&) {
    throw ConfigError("token file: must be a list of {\"sha256\": …, \"scopes\": […]}");
  }
  if (list.tokens_.empty()) throw ConfigError("token file: must have at least one token");
  return list;
}

void TokenList::Require(Scope scope, const std::string& authorization) const {
  if (scope == Scope::kNone || (!is_asked_for_ && scope != Scope::kCommand)) return;
  if (!is_asked_for_) {
    throw ApiError("Unauthorized",
                   "a command needs a token with the scope command, and this server was started "
                   "without a token file");
  }
  constexpr std::string_view kScheme = "Bearer ";
  const bool is_bearer = authorization.size() > kScheme.size() &&
                         authorization.size() <= kScheme.size() + kMaxTokenBytes &&
                         IsSameScheme(authorization.substr(0, kScheme.size()), kScheme);
  const std::string sha256 =
      Sha256Hex(is_bearer ? authorization.substr(kScheme.size()) : std::string());
  // Compares all tokens, each in constant time, so that the duration reveals nothing.
  const Token* known = nullptr;
  for (const Token& token : tokens_) {
    const bool is_equal = CRYPTO_memcmp(token.sha256.data(), sha256.data(), kSha256HexDigits) == 0;
    if (is_equal) known = &token;
  }
  if (!is_bearer || known == nullptr) {
    throw ApiError("Unauthorized", "a valid token is needed: Authorization: Bearer …");
  }
  if (std::find(known->scopes.begin(), known->scopes.end(), scope) == known->scopes.end()) {
    throw ApiError("Forbidden", "the token's scopes do not allow this");
  }
}

}  // namespace freelsd
