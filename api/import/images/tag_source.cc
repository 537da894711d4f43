#include "api/import/images/tag_source.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>

#include <exiv2/exiv2.hpp>

#include "api/import/images/image_segments.h"
#include "api/import/number_text.h"
#include "api/limits.h"

namespace freelsd {
namespace {

// The list of XMP namespaces is global and grows while exiv2 reads.
std::mutex& Exiv2Mutex() {
  static std::mutex mutex;  // Guards exiv2's global list of XMP namespaces.
  return mutex;
}

void PrepareExiv2() {
  static const bool kIsReady = [] {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
    return Exiv2::XmpParser::initialize();
  }();
  static_cast<void>(kIsReady);
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

// Refuses common attacks on XML readers: entities, encodings other than UTF-8, deep nesting.
bool IsHarmlessXmp(std::string_view packet) {
  if (packet.find('\0') != std::string_view::npos) return false;
  if (packet.find("<!") != std::string_view::npos) return false;
  int depth = 0;
  size_t end = 0;
  for (size_t at = packet.find('<'); at != std::string_view::npos; at = packet.find('<', end)) {
    end = packet.find('>', at);
    if (end == std::string_view::npos) return false;
    const char next = packet[at + 1];
    if (next == '/') {
      --depth;
    } else if (next != '?' && packet[end - 1] != '/' && ++depth > kLimits.tags.max_xmp_depth) {
      return false;
    }
  }
  return true;
}

double ComponentOf(const Exiv2::Exifdatum& datum, long index) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  const Exiv2::TypeId type = datum.typeId();
  if (type != Exiv2::unsignedRational && type != Exiv2::signedRational) {
    return static_cast<double>(datum.toLong(index));
  }
  const Exiv2::Rational rational = datum.toRational(index);
  if (rational.second == 0) return kNothing;
  // exiv2 reads unsigned numerators and denominators as signed.
  const bool is_unsigned = type == Exiv2::unsignedRational;
  const double numerator = is_unsigned ? static_cast<uint32_t>(rational.first) : rational.first;
  const double denominator = is_unsigned ? static_cast<uint32_t>(rational.second) : rational.second;
  return numerator / denominator;
}

bool IsNumeric(Exiv2::TypeId type) {
  return type == Exiv2::unsignedByte || type == Exiv2::unsignedShort ||
         type == Exiv2::unsignedLong || type == Exiv2::unsignedRational ||
         type == Exiv2::signedShort || type == Exiv2::signedLong || type == Exiv2::signedRational;
}

}  // namespace

TagSource::TagSource(std::string_view image_bytes) {
  const MetadataBlocks blocks = FindMetadata(image_bytes);
  const std::lock_guard<std::mutex> lock(Exiv2Mutex());
  PrepareExiv2();
  // Tags are optional, so tags that exiv2 cannot read count as absent.
  try {
    ReadExif(blocks.exif);
  } catch (const std::exception&) {
    exif_text_.clear();
    exif_numbers_.clear();
  }
  try {
    ReadXmp(blocks.xmp);
  } catch (const std::exception&) {
    xmp_.clear();
  }
}

void TagSource::ReadExif(std::string_view block) {
  if (block.empty() || block.size() > kLimits.tags.max_block_bytes) return;
  Exiv2::ExifData data;
  Exiv2::ExifParser::decode(data,
                            reinterpret_cast<const Exiv2::byte*>(block.data()),
                            static_cast<uint32_t>(block.size()));
  for (const Exiv2::Exifdatum& datum : data) {
    const std::string group = datum.groupName();
    if (group != "Image" && group != "Photo" && group != "GPSInfo") continue;
    if (datum.typeId() == Exiv2::asciiString) {
      exif_text_.emplace(
          datum.key(),
          std::string(Trimmed(datum.toString())).substr(0, kLimits.tags.max_text_bytes));
    } else if (IsNumeric(datum.typeId())) {
      std::vector<double> numbers;
      const long count = std::min<long>(datum.count(), kLimits.tags.max_num_components);
      for (long i = 0; i < count; ++i) numbers.push_back(ComponentOf(datum, i));
      exif_numbers_.emplace(datum.key(), numbers);
    }
  }
}

void TagSource::ReadXmp(std::string_view block) {
  if (block.empty() || block.size() > kLimits.tags.max_block_bytes || !IsHarmlessXmp(block)) return;
  Exiv2::XmpData data;
  if (Exiv2::XmpParser::decode(data, std::string(block)) != 0) return;
  for (const Exiv2::Xmpdatum& datum : data) {
    const std::string text = datum.toString();
    if (text.size() > kLimits.tags.max_text_bytes) continue;
    xmp_.emplace(Lower(datum.groupName() + "." + datum.tagName()), text);
  }
  Exiv2::XmpProperties::unregisterNs();
}

std::optional<double> TagSource::ExifNumber(const std::string& key, size_t index) const {
  const auto found = exif_numbers_.find(key);
  if (found == exif_numbers_.end() || index >= found->second.size()) return std::nullopt;
  const double number = found->second[index];
  if (!std::isfinite(number)) return std::nullopt;
  return number;
}

std::optional<std::string> TagSource::ExifText(const std::string& key) const {
  const auto found = exif_text_.find(key);
  if (found == exif_text_.end() || found->second.empty()) return std::nullopt;
  return found->second;
}

std::optional<std::string> TagSource::XmpText(std::string_view prefix,
                                              std::string_view name) const {
  const std::string wanted_prefix = Lower(prefix);
  const std::string wanted_name = Lower(std::string(".").append(name));
  for (auto tag = xmp_.lower_bound(wanted_prefix); tag != xmp_.end(); ++tag) {
    const std::string& key = tag->first;
    if (key.rfind(wanted_prefix, 0) != 0) break;
    if (key.size() > wanted_name.size() &&
        key.compare(key.size() - wanted_name.size(), std::string::npos, wanted_name) == 0) {
      return tag->second;
    }
  }
  return std::nullopt;
}

std::optional<double> TagSource::XmpNumber(std::string_view prefix, std::string_view name) const {
  const std::optional<std::string> text = XmpText(prefix, name);
  return text ? NumberFromText(*text) : std::nullopt;
}

std::vector<double> TagSource::XmpNumbers(std::string_view prefix, std::string_view name) const {
  const std::string text = XmpText(prefix, name).value_or("");
  std::vector<double> numbers;
  size_t start = 0;
  while (!text.empty() && start <= text.size()) {
    const size_t end = std::min(text.find(',', start), text.size());
    const std::optional<double> number =
        NumberFromText(std::string_view(text).substr(start, end - start));
    if (!number) return {};
    numbers.push_back(*number);
    start = end + 1;
  }
  return numbers;
}

}  // namespace freelsd
