// freelsd-migrate: moves all rows and images from SQLite to PostgreSQL or back.
#include <cstdio>
#include <exception>
#include <iterator>
#include <set>
#include <stdexcept>

#include <openssl/evp.h>

#include "storage/image_files.h"
#include "storage/move/move.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

constexpr int kNumRowsOfCommit = 1000;

// SHA-256 in lower-case hexadecimal digits.
class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    if (EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) {
      throw std::runtime_error("SHA-256 is missing");
    }
  }
  void Add(std::string_view bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
  // With its length, so that values cannot run into each other.
  void AddValue(char kind, std::string_view bytes) {
    Add(kind + std::to_string(bytes.size()) + ':');
    Add(bytes);
  }
  std::string Hex() {
    unsigned char bytes[EVP_MAX_MD_SIZE];
    unsigned int size = 0;
    EVP_DigestFinal_ex(context_.get(), bytes, &size);
    std::string hex;
    for (unsigned int i = 0; i < size; ++i) {
      constexpr char kDigits[] = "0123456789abcdef";
      hex += kDigits[bytes[i] >> 4U];
      hex += kDigits[bytes[i] & 15U];
    }
    return hex;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

void AddRow(Sha256& digest, const MovedTable& table, const MovedRow& row) {
  for (size_t i = 0; i < row.size(); ++i) {
    if (!table.columns[i].is_compared) continue;
    if (const auto* text = std::get_if<std::string>(&row[i])) {
      digest.AddValue('t', *text);
    } else if (const auto* integer = std::get_if<int64_t>(&row[i])) {
      digest.AddValue('i', std::to_string(*integer));
    } else if (const auto* real = std::get_if<double>(&row[i])) {
      // SQLite does not keep the sign of zero.
      const double value = *real + 0.0;
      digest.AddValue('r', {reinterpret_cast<const char*>(&value), sizeof(value)});
    } else {
      digest.AddValue('n', {});
    }
  }
}

struct TableDigest {
  int64_t num_rows = 0;
  std::string digest;

  bool operator==(const TableDigest&) const = default;
};

TableDigest DigestOf(RowSource& source, const MovedTable& table) {
  TableDigest result;
  Sha256 digest;
  source.ForEach(table, [&](const MovedRow& row) {
    ++result.num_rows;
    AddRow(digest, table, row);
  });
  result.digest = digest.Hex();
  return result;
}

// A table that an earlier run has finished is left alone.
void MoveTable(RowSource& from, RowTarget& to, const MovedTable& table) {
  if (DigestOf(from, table) == DigestOf(to, table)) return;
  int num_rows = 0;
  from.ForEach(table, [&](const MovedRow& row) {
    to.Put(table, row);
    if (++num_rows % kNumRowsOfCommit == 0) to.Commit();
  });
  to.Commit();
}

// SHA-256 of all images that frames and pictures of maps name, in order.
std::set<std::string> ImagesOf(RowSource& source) {
  std::set<std::string> images;
  for (const MovedTable& table : MovedTables()) {
    if (table.name != "frames" && table.name != "photo_tiles") continue;
    const size_t column = table.name == "frames" ? 3 : 4;
    source.ForEach(table,
                   [&](const MovedRow& row) { images.insert(std::get<std::string>(row[column])); });
  }
  return images;
}

std::string Sha256Of(std::string_view bytes) {
  Sha256 digest;
  digest.Add(bytes);
  return digest.Hex();
}

// An image that was removed to free space has no file; its row says so.
void MoveImages(const std::set<std::string>& wanted,
                const ImageFiles& from,
                const ImageFiles& to,
                RowTarget& target) {
  int64_t num_images = 0;
  for (const std::string& sha256 : wanted) {
    const std::optional<std::string> bytes = from.Read(sha256);
    if (!bytes) continue;
    if (Sha256Of(*bytes) != sha256) {
      throw StorageError("read image " + sha256, "its bytes are damaged", StorageFault::kDamaged);
    }
    if (!to.Has(sha256)) to.Write(sha256, *bytes);
    target.PutImageRow(sha256, static_cast<int64_t>(bytes->size()));
    if (++num_images % kNumRowsOfCommit == 0) target.Commit();
  }
  target.Commit();
}

void CheckImages(const std::set<std::string>& wanted,
                 const ImageFiles& from,
                 const ImageFiles& to) {
  Sha256 digest;
  int64_t num_equal = 0;
  for (const std::string& sha256 : wanted) {
    const std::optional<std::string> bytes = to.Read(sha256);
    if (!bytes && !from.Has(sha256)) continue;
    if (!bytes || Sha256Of(*bytes) != sha256) {
      throw StorageError("compare image " + sha256, "it did not arrive as it was");
    }
    digest.Add(sha256);
    ++num_equal;
  }
  std::printf(
      "%-12s %10lld  %s\n", "images", static_cast<long long>(num_equal), digest.Hex().c_str());
}

void CheckTable(RowSource& from, RowTarget& to, const MovedTable& table) {
  const TableDigest source = DigestOf(from, table), target = DigestOf(to, table);
  std::printf("%-12s %10lld  %s\n",
              table.name.c_str(),
              static_cast<long long>(target.num_rows),
              target.digest.c_str());
  if (source == target) return;
  throw StorageError("compare " + table.name,
                     "the source has " + std::to_string(source.num_rows) + " rows with digest " +
                         source.digest + "; a target with other data stays as it is");
}

struct Arguments {
  std::string from, to, images;
};

Arguments ParseArguments(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--from") arguments.from = argv[i + 1];
    if (name == "--to") arguments.to = argv[i + 1];
    if (name == "--images") arguments.images = argv[i + 1];
  }
  if (argc == 7 && !arguments.from.empty() && !arguments.to.empty() && !arguments.images.empty()) {
    return arguments;
  }
  throw std::invalid_argument(
      "usage: freelsd-migrate --from DIR --to postgresql://... --images DIR, or --from "
      "postgresql://... --to DIR --images DIR; --images is the folder beside the PostgreSQL "
      "database");
}

bool IsPostgres(const std::string& place) {
  return place.starts_with("postgresql://") || place.starts_with("postgres://");
}

void Move(const Arguments& arguments) {
  if (IsPostgres(arguments.from) == IsPostgres(arguments.to)) {
    throw std::invalid_argument("one of --from and --to must be a folder, the other a URI");
  }
  const bool is_to_postgres = IsPostgres(arguments.to);
  const auto from =
      is_to_postgres ? OpenSqliteSource(arguments.from) : OpenPostgresSource(arguments.from);
  const auto to =
      is_to_postgres ? OpenPostgresTarget(arguments.to) : OpenSqliteTarget(arguments.to);
  const std::string beside_sqlite = (is_to_postgres ? arguments.from : arguments.to) + "/images";
  const ImageFiles source_images(is_to_postgres ? beside_sqlite : arguments.images);
  const ImageFiles target_images(is_to_postgres ? arguments.images : beside_sqlite);
  const std::set<std::string> wanted = ImagesOf(*from);
  if (!to->IsComplete()) {
    MoveImages(wanted, source_images, target_images, *to);
    for (const MovedTable& table : MovedTables()) MoveTable(*from, *to, table);
  }
  for (const MovedTable& table : MovedTables()) CheckTable(*from, *to, table);
  CheckImages(wanted, source_images, target_images);
  if (!to->IsComplete()) to->Complete();
}

int Run(int argc, char** argv) {
  try {
    Move(ParseArguments(argc, argv));
    std::puts("moved; all rows and images are equal");
    return 0;
  } catch (const std::invalid_argument& error) {
    std::fprintf(stderr, "freelsd-migrate: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "freelsd-migrate: %s\n", error.what());
    return 1;
  }
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) { return freelsd::Run(argc, argv); }
