#include "server/handlers/export/answer_format.h"

#include <algorithm>
#include <sstream>

#include "api/api.h"

namespace freelsd {
namespace {

struct AcceptedType {
  std::string media_type;
  double quality = 1.0;
};

std::vector<AcceptedType> ParseAccept(const std::string& header) {
  std::vector<AcceptedType> types;
  std::istringstream ranges(header);
  for (std::string range; std::getline(ranges, range, ',');) {
    std::erase(range, ' ');
    const size_t end = range.find(';');
    AcceptedType type{range.substr(0, end)};
    const size_t quality = range.find(";q=");
    if (quality != std::string::npos) type.quality = std::atof(range.c_str() + quality + 3);
    types.push_back(type);
  }
  std::stable_sort(types.begin(), types.end(), [](const auto& left, const auto& right) {
    return left.quality > right.quality;
  });
  return types;
}

SiteFormat NamedFormat(const std::string& name, const std::vector<SiteFormat>& formats) {
  std::string names;
  for (const SiteFormat& format : formats) {
    if (name == format.name) return format;
    names += (names.empty() ? "" : ", ") + std::string(format.name);
  }
  throw ApiError("InvalidQuery", "f: must be one of " + names, {{"f", "must be one of " + names}});
}

}  // namespace

SiteFormat FormatOf(const Call& call, const std::vector<SiteFormat>& formats) {
  if (const auto name = call.Query("f")) return NamedFormat(*name, formats);
  for (const AcceptedType& accepted : ParseAccept(call.request.get_header_value("Accept"))) {
    if (accepted.media_type == "*/*" || accepted.media_type == "application/json") break;
    for (const SiteFormat& format : formats) {
      if (accepted.quality > 0.0 && accepted.media_type == format.media_type) return format;
    }
  }
  return formats.front();
}

void AnswerReport(const std::string& page, httplib::Response& response) {
  response.set_header("Vary", "Accept");
  response.set_header("Content-Security-Policy",
                      "default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
                      "frame-ancestors 'none'");
  response.set_content(page, "text/html; charset=utf-8");
}

}  // namespace freelsd
