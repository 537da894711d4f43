// Moves damaged database files aside, at a start, and leaves marks for the next start.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freelsd {

inline constexpr char kDatabaseName[] = "freelsd.db";
// The second copy of the sites.
inline constexpr char kCopyName[] = "recall.db";

// Writes a mark: the next start moves the database aside.
void MarkForSettingAside(const std::filesystem::path& folder, const std::string& why);

// Writes a mark: the next start rebuilds the copy from the database.
void MarkCopy(const std::filesystem::path& folder);
// Removes that mark; true if there was one.
bool TakeMarkOfCopy(const std::filesystem::path& folder);
// Moves the copy into a folder of its own.
void SetCopyAside(const std::filesystem::path& folder);

// Moves the database and the images into a folder of their own if the database is marked, cannot be
// read, or has another schema version than the copy. Returns sentences for Storage::Notices. Call
// it before any file is opened. Throws StorageError, and moves nothing, if a newer program wrote a
// file.
std::vector<std::string> SetAsideWhenDamaged(const std::filesystem::path& folder);

// Removes the file with its -wal and -shm files.
void RemoveDatabase(const std::filesystem::path& file);

}  // namespace freelsd
