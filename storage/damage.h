// What is done where the database's file is not what was written.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freelsd {

inline constexpr char kDatabaseName[] = "freelsd.db";
// The sites' second copy.
inline constexpr char kCopyName[] = "recall.db";

// The next start sets the database aside.
void MarkForSettingAside(const std::filesystem::path& folder, const std::string& why);

// The next start makes the copy anew from the database. Whether it was marked; it is not
// afterwards.
void MarkCopy(const std::filesystem::path& folder);
bool TakeMarkOfCopy(const std::filesystem::path& folder);
// Moves the copy into a folder of its own.
void SetCopyAside(const std::filesystem::path& folder);

// Moves a database that is marked, cannot be read, or is not of its copy's version, into a folder
// of its own, with the images; what was done, in sentences. To be called before anything is opened.
// Throws StorageError, and moves nothing, where a newer program wrote a file.
std::vector<std::string> SetAsideWhenDamaged(const std::filesystem::path& folder);

// As SQLite moves them about: the file, its log and its index.
void RemoveDatabase(const std::filesystem::path& file);

}  // namespace freelsd
