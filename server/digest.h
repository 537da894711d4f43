// Repr-Digest (RFC 9530) of an upload.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

// Throws ApiError DigestMismatch unless the header's sha-256 is one of `accepted_sha256`
// (lower-case hex), InvalidRequest when it is malformed. Other algorithms are passed over.
void CheckDigest(const std::string& header, const std::vector<std::string>& accepted_sha256);

}  // namespace freelsd
