// Who may call: bearer tokens, of which only hashes are kept.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freelsd {

enum class Scope { kNone, kRead, kIngest, kAdmin };

class TokenList {
 public:
  // Nobody is asked for a token.
  TokenList() = default;
  // JSON: [{"sha256": hex of the token's SHA-256, "scopes": ["read", "ingest", "admin"]}]. Throws
  // ConfigError: also for a file that others than its owner may read.
  static TokenList Read(const std::filesystem::path& file);

  // `authorization`: the header's value. Throws ApiError Unauthorized without a known token,
  // Forbidden where its scopes lack the one needed.
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
