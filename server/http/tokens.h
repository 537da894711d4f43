// Checks bearer tokens. Only hashes of the tokens are stored.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freelsd {

// The scope that a route requires, or that a token grants. kNone: no token is needed.
// kCommand: what an aircraft may do; it needs a token even if nothing else does.
enum class Scope { kNone, kRead, kIngest, kAdmin, kCommand };

// The accepted tokens. Immutable, so thread-safe.
class TokenList {
 public:
  // An empty list: requests need no token, and none may command.
  TokenList() = default;
  // Reads JSON: [{"sha256": hex of the token's SHA-256, "scopes": ["read", "ingest", "admin",
  // "command"]}]. Throws ConfigError if the file is invalid, or if anyone but the owner has access
  // to it.
  static TokenList Read(const std::filesystem::path& file);

  // `authorization`: value of the header. Throws ApiError Unauthorized if the token is missing or
  // unknown, Forbidden if it does not grant `scope`.
  void Require(Scope scope, const std::string& authorization) const;

 private:
  struct Token {
    std::string sha256;
    std::vector<Scope> scopes;
  };
  bool is_asked_for_ = false;
  std::vector<Token> tokens_;
};

}  // namespace freelsd
