// Tags of an image by name, as text or numbers. A missing or malformed tag counts as absent. Of a
// tag that several blocks have, the first one counts.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace Exiv2 {  // NOLINT(readability-identifier-naming): the library's name
class Exifdatum;
}

namespace freelsd {

class TagSource {
 public:
  // Reads the EXIF and XMP blocks of a JPEG or PNG. Never throws for malformed content. Several
  // threads may read at once.
  explicit TagSource(std::string_view image_bytes);

  // `key` is exiv2's name, for example "Exif.GPSInfo.GPSLatitude"; `index` is the component.
  std::optional<double> ExifNumber(const std::string& key, size_t index = 0) const;
  // All components; NaN where one is no number. Empty without the tag.
  std::vector<double> ExifNumbers(const std::string& key) const;
  std::optional<std::string> ExifText(const std::string& key) const;
  // Searches the namespaces whose prefix starts with `prefix`, ignoring case.
  std::optional<double> XmpNumber(std::string_view prefix, std::string_view name) const;
  std::optional<std::string> XmpText(std::string_view prefix, std::string_view name) const;
  // Reads comma-separated numbers. Empty if one of them is no number.
  std::vector<double> XmpNumbers(std::string_view prefix, std::string_view name) const;

  // Blocks and properties that could not be read.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  void ReadExif(std::string_view block);
  void Keep(const Exiv2::Exifdatum& datum);

  std::map<std::string, std::string> exif_text_;
  std::map<std::string, std::vector<double>> exif_numbers_;
  // By lower-case "prefix.name".
  std::map<std::string, std::string> xmp_;
  std::vector<std::string> warnings_;
};

}  // namespace freelsd
