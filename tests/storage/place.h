// A fresh place for a storage, in the database that the suite runs on: PostgreSQL, if
// FREELSD_TEST_DATABASE is a URI of one, or else SQLite.
#pragma once

#include <filesystem>
#include <string>

#include "storage/storage.h"
#include "tests/storage/temporary_folder.h"

namespace freelsd {

// The storage of a folder, always the same: in PostgreSQL a schema of its own, which stays.
StorageOptions StorageAt(const std::filesystem::path& folder);

// Removed at the end: the folder, and in PostgreSQL a schema of its own.
class StoragePlace {
 public:
  StoragePlace();
  ~StoragePlace();
  StoragePlace(const StoragePlace&) = delete;
  StoragePlace& operator=(const StoragePlace&) = delete;

  static DatabaseKind Kind();
  // Images that nothing refers to are removed at the next start, however young.
  StorageOptions options() const;
  // For two processes that share a database and its images; each has a folder of its own.
  StorageOptions OptionsOfOne() const;
  StorageOptions OptionsOfOther() const;
  std::filesystem::path images_folder() const { return folder_.path() / "images"; }
  // Runs SQL in the PostgreSQL schema.
  void Execute(const std::string& sql) const;
  // All tables of the PostgreSQL schema with their columns and rows, as text.
  std::string Content() const;

 private:
  TemporaryFolder folder_;
  std::string schema_;
};

}  // namespace freelsd
