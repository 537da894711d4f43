// Names and digests of incoming files: frame ids, SHA-256, paths that are safe to print. Every
// function in this folder treats its input as hostile.
#pragma once

#include <string>
#include <string_view>

namespace freelsd {

// True for "[A-Za-z0-9._-]{1,128}" except "." and "..".
bool IsValidId(std::string_view id);
// The file name without folders. Characters that no id may contain become "_".
std::string IdFromFileName(std::string_view file_name);
// An id of the whole path, for files that share a name. Folders are separated by "_", and each
// other character that no id may contain becomes "-" and its code.
std::string IdFromPath(std::string_view path);
// Lower-case hex.
std::string Sha256Hex(std::string_view bytes);
// The path in printable ASCII, shortened for messages.
std::string ShownPath(const std::string& path);

}  // namespace freelsd
