#include "api/import/images/tag_source.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>

#include <exiv2/exiv2.hpp>

#include "api/import/images/image_segments.h"
#include "api/import/images/xmp.h"
#include "api/import/number_text.h"
#include "api/limits.h"

namespace freelsd {
namespace {

std::mutex& Exiv2Mutex() {
  // Guards the global state with which exiv2 reads XMP within EXIF.
  static std::mutex mutex;
  return mutex;
}

void PrepareExiv2() {
  static const bool kIsReady = [] {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
    return Exiv2::XmpParser::initialize();
  }();
  static_cast<void>(kIsReady);
}

// Some programs write decimal commas.
std::optional<double> DecimalFromText(std::string text) {
  const size_t comma = text.find(',');
  const bool is_decimal =
      comma != std::string::npos && comma == text.rfind(',') && text.find('.') == std::string::npos;
  if (is_decimal) text[comma] = '.';
  return NumberFromText(text);
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
  for (const std::string_view block : blocks.exif) ReadExif(block);
  for (const std::string_view block : blocks.xmp) {
    XmpProperties read = ReadXmp(block);
    xmp_.merge(read.values);
    warnings_.insert(warnings_.end(), read.warnings.begin(), read.warnings.end());
  }
}

void TagSource::ReadExif(std::string_view block) {
  const std::lock_guard<std::mutex> lock(Exiv2Mutex());
  PrepareExiv2();
  Exiv2::ExifData data;
  try {
    if (block.size() <= kLimits.tags.max_block_bytes) {
      Exiv2::ExifParser::decode(data,
                                reinterpret_cast<const Exiv2::byte*>(block.data()),
                                static_cast<uint32_t>(block.size()));
    }
  } catch (const std::exception&) {
    data.clear();
  }
  if (data.empty()) warnings_.emplace_back("the EXIF is damaged or too large: it is not read");
  for (const Exiv2::Exifdatum& datum : data) Keep(datum);
}

void TagSource::Keep(const Exiv2::Exifdatum& datum) {
  const std::string group = datum.groupName();
  if (group != "Image" && group != "Photo" && group != "GPSInfo") return;
  if (datum.typeId() == Exiv2::asciiString) {
    exif_text_.emplace(
        datum.key(), std::string(Trimmed(datum.toString())).substr(0, kLimits.tags.max_text_bytes));
  } else if (IsNumeric(datum.typeId())) {
    std::vector<double> numbers;
    const long count = std::min<long>(datum.count(), kLimits.tags.max_num_components);
    for (long i = 0; i < count; ++i) numbers.push_back(ComponentOf(datum, i));
    exif_numbers_.emplace(datum.key(), numbers);
  }
}

std::vector<double> TagSource::ExifNumbers(const std::string& key) const {
  const auto found = exif_numbers_.find(key);
  return found == exif_numbers_.end() ? std::vector<double>{} : found->second;
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
  const std::string wanted_prefix = InLowerCase(prefix);
  const std::string wanted_name = InLowerCase(std::string(".").append(name));
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
  return text ? DecimalFromText(*text) : std::nullopt;
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
