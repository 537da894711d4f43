// Checks the Repr-Digest header (RFC 9530) of an upload.
#pragma once

#include <string>
#include <vector>

namespace freelsd {

// Throws ApiError DigestMismatch if the header's sha-256 is not one of `accepted_sha256`
// (lower-case hex). Throws ApiError InvalidRequest if the header is malformed. Ignores other
// algorithms.
void CheckDigest(const std::string& header, const std::vector<std::string>& accepted_sha256);

}  // namespace freelsd
