// Image files, named by their SHA-256 and distributed over 256 folders: images/ab/abcd... A file
// with its final name is complete and synced to disk. Several processes may share the folder.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

class ImageFiles {
 public:
  // Creates the folder and its 256 subfolders.
  explicit ImageFiles(const std::filesystem::path& folder);

  // Writes a temporary file, syncs it, renames it and syncs the folder. Throws StorageError.
  void Write(const std::string& sha256, std::string_view bytes) const;
  std::optional<std::string> Read(const std::string& sha256) const;
  bool Has(const std::string& sha256) const;
  void Remove(const std::string& sha256) const;
  // Total size of all files.
  uint64_t NumBytes() const;
  // Names of the 256 subfolders.
  static std::vector<std::string> Shelves();
  // Names of files in a subfolder that were written at least age_s ago, unfinished ones too.
  std::vector<std::string> Old(const std::string& shelf, double age_s) const;
  static bool IsUnfinished(const std::string& name);
  // Removes every file that is not needed, including unfinished files.
  void RemoveUnless(const std::function<bool(const std::string& sha256)>& is_needed) const;

 private:
  std::filesystem::path PathOf(const std::string& sha256) const;

  std::filesystem::path folder_;
};

// Syncs a folder to disk, so that the file names in it survive a power loss. Throws StorageError.
void SyncFolder(const std::filesystem::path& folder);

}  // namespace freelsd
