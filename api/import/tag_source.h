// Tags of an image by name, as text or numbers; absent where they are missing or make no sense.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

// "+121.6", "1/3", " 12 "; finite, or nothing.
std::optional<double> NumberFromText(std::string_view text);

class TagSource {
 public:
  // Reads the EXIF and XMP blocks of a JPEG or PNG. Never throws for odd content; safe from several
  // threads.
  explicit TagSource(std::string_view image_bytes);

  // Keys as exiv2 names them: "Exif.GPSInfo.GPSLatitude"; `index` is the component.
  std::optional<double> ExifNumber(const std::string& key, size_t index = 0) const;
  std::optional<std::string> ExifText(const std::string& key) const;
  // Of the namespaces whose prefix starts with `prefix`; case does not matter.
  std::optional<double> XmpNumber(std::string_view prefix, std::string_view name) const;
  std::optional<std::string> XmpText(std::string_view prefix, std::string_view name) const;
  // Comma-separated numbers; empty unless all are.
  std::vector<double> XmpNumbers(std::string_view prefix, std::string_view name) const;

 private:
  void ReadExif(std::string_view block);
  void ReadXmp(std::string_view block);

  std::map<std::string, std::string> exif_text_;
  std::map<std::string, std::vector<double>> exif_numbers_;
  // By lower-case "prefix.name".
  std::map<std::string, std::string> xmp_;
};

}  // namespace freelsd
