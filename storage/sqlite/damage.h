// Moves damaged database files aside when the program starts. Mark files request this for the next
// start.
#pragma once

#include <filesystem>
#include <string>

namespace freelsd {

// Writes a mark file, so that the next start moves the database aside.
void MarkForSettingAside(const std::filesystem::path& folder, const std::string& why);
// The same for the second copy.
void MarkCopy(const std::filesystem::path& folder, const std::string& why);

// What was moved aside, as sentences; empty for nothing.
struct SetAside {
  std::string database;
  std::string copy;

  bool IsEmpty() const { return database.empty() && copy.empty(); }
};

// Moves the database with the images into a new folder if it is marked, cannot be read or is lost,
// or if only the copy has this program's schema; and the copy if it is marked or cannot be
// read. Call it before any file is opened. Returns what was moved, also by earlier starts that did
// not come to ForgetSetAside. Throws StorageError kOtherSchema, and changes nothing, if a file has
// a schema of another number.
SetAside SetAsideWhenDamaged(const std::filesystem::path& folder);
// Call it when a notice tells what was moved and what was restored.
void ForgetSetAside(const std::filesystem::path& folder);

}  // namespace freelsd
