// Moves damaged database files aside when the program starts. Mark files request this for the next
// start.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freelsd {

inline constexpr char kDatabaseName[] = "freelsd.db";
// The second copy of the sites.
inline constexpr char kCopyName[] = "recall.db";

// Writes a mark file, so that the next start moves the database aside.
void MarkForSettingAside(const std::filesystem::path& folder, const std::string& why);

// Writes a mark file, so that the next start rebuilds the copy from the database.
void MarkCopy(const std::filesystem::path& folder);
// Removes the mark file of the copy; true if there was one.
bool TakeMarkOfCopy(const std::filesystem::path& folder);
// Moves the copy into a new folder.
void SetCopyAside(const std::filesystem::path& folder);

// Moves the database and the images into a new folder if the database is marked or cannot be read,
// or if only the copy has the current schema version. Returns messages for Storage::Notices. Call
// it before any file is opened. Throws StorageError, and moves nothing, if a newer program wrote a
// file.
std::vector<std::string> SetAsideWhenDamaged(const std::filesystem::path& folder);

// Removes the file with its -wal and -shm files.
void RemoveDatabase(const std::filesystem::path& file);

}  // namespace freelsd
