#include "api/import/images/xmp.h"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include <libxml/parser.h>
#include <libxml/tree.h>

#include "api/import/number_text.h"
#include "api/limits.h"

namespace freelsd {
namespace {

constexpr int kParserOptions = XML_PARSE_RECOVER | XML_PARSE_NONET | XML_PARSE_NOERROR |
                               XML_PARSE_NOWARNING | XML_PARSE_NOCDATA | XML_PARSE_IGNORE_ENC;

// Programs choose the prefix freely; the end of the namespace counts.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kPrefixes{{
    {"dji.com/drone-dji/1.0", "drone-dji"},
    {"parrot.com/drone-parrot/1.0", "drone-parrot"},
    {"pix4d.com/camera/1.0", "camera"},
    {"ns.adobe.com/exif/1.0", "exif"},
    {"ns.adobe.com/photoshop/1.0", "photoshop"},
    {"ns.adobe.com/xap/1.0", "xmp"},
}};

std::string_view View(const xmlChar* text) {
  return text == nullptr ? std::string_view() : reinterpret_cast<const char*>(text);
}

// Plain ASCII, because names and values that matter are. UTF-16 has a zero beside each character.
std::string Plain(std::string_view packet) {
  const auto num_zeros = std::count(packet.begin(), packet.end(), '\0');
  const bool is_utf16 = 3 * static_cast<size_t>(num_zeros) > packet.size();
  std::string plain;
  for (const char c : packet) {
    if (c == '\0' && is_utf16) continue;
    const bool is_text = (c >= ' ' && c <= '~') || c == '\t' || c == '\n' || c == '\r';
    plain += is_text ? c : c > 0 && c < ' ' ? ' ' : c == '\0' ? ' ' : '?';
  }
  // A parser accepts nothing before the first tag.
  plain.erase(0, std::min(plain.find('<'), plain.size()));
  return plain;
}

std::string KeyOf(const xmlNs* space, const xmlChar* name) {
  if (space == nullptr) {
    // The prefix of a namespace that is not declared is part of the name.
    std::string key = InLowerCase(View(name));
    std::replace(key.begin(), key.end(), ':', '.');
    return key;
  }
  std::string uri = InLowerCase(View(space->href));
  if (uri.ends_with('/')) uri.pop_back();
  std::string_view prefix = View(space->prefix);
  for (const auto& [end, known] : kPrefixes) {
    if (uri.ends_with(end)) prefix = known;
  }
  return InLowerCase(std::string(prefix) + "." + std::string(View(name)));
}

class Reader {
 public:
  explicit Reader(XmpProperties& read) : read_(read) {}

  // The parser bounds the depth.
  void Take(const xmlNode* node) {
    for (; node != nullptr; node = node->next) {
      if (node->type != XML_ELEMENT_NODE) continue;
      for (const xmlAttr* each = node->properties; each != nullptr; each = each->next) {
        Add(KeyOf(each->ns, each->name), TextOf(each->children));
      }
      const std::string text = TextOf(node->children);
      if (!Trimmed(text).empty()) Add(KeyOf(node->ns, node->name), text);
      Take(node->children);
    }
  }

 private:
  // The items of a list are separated by commas.
  static std::string TextOf(const xmlNode* node) {
    std::string text;
    for (; node != nullptr; node = node->next) {
      if (node->type == XML_TEXT_NODE || node->type == XML_CDATA_SECTION_NODE) {
        text += View(node->content);
        continue;
      }
      const std::string_view name = View(node->name);
      const bool is_list = name == "Seq" || name == "Bag" || name == "li";
      if (node->type != XML_ELEMENT_NODE || !is_list) continue;
      const std::string items = TextOf(node->children);
      text = std::string(Trimmed(text));
      text += (text.empty() || Trimmed(items).empty() ? "" : ",") + std::string(Trimmed(items));
    }
    return text;
  }

  void Add(const std::string& key, const std::string& text) {
    if (text.size() > kLimits.tags.max_text_bytes || key.starts_with("rdf.")) return;
    const auto [at, is_new] = read_.values.emplace(key, text);
    if (is_new || Trimmed(at->second) == Trimmed(text)) return;
    const bool is_known = std::any_of(kPrefixes.begin(), kPrefixes.end(), [&key](const auto& each) {
      return key.starts_with(std::string(each.second) + ".");
    });
    if (is_known) {
      read_.warnings.push_back("the XMP has two values of " + key + ": the first one is used");
    }
  }

  XmpProperties& read_;
};

struct FreeDocument {
  void operator()(xmlDoc* document) const { xmlFreeDoc(document); }
};

}  // namespace

XmpProperties ReadXmp(std::string_view packet) {
  static const bool kIsReady = (xmlInitParser(), true);
  static_cast<void>(kIsReady);
  XmpProperties read;
  const std::string text = Plain(packet);
  // Entities are common attacks on XML readers, and no camera writes any.
  if (packet.size() > kLimits.tags.max_block_bytes || text.find("<!DOCTYPE") != std::string::npos ||
      text.find("<!ENTITY") != std::string::npos) {
    read.warnings.emplace_back("the XMP is too large or has a document type: it is not read");
    return read;
  }
  xmlResetLastError();
  const std::unique_ptr<xmlDoc, FreeDocument> document(
      xmlReadMemory(text.data(), static_cast<int>(text.size()), nullptr, "UTF-8", kParserOptions));
  const xmlError* const error = xmlGetLastError();
  const bool is_damaged = error != nullptr && error->level == XML_ERR_FATAL;
  if (document) Reader(read).Take(xmlDocGetRootElement(document.get()));
  if (read.values.empty()) {
    read.warnings.emplace_back("the XMP cannot be read: its angles and heights are not used");
  } else if (is_damaged) {
    read.warnings.emplace_back("the XMP is damaged: of its properties " +
                               std::to_string(read.values.size()) + " could be read");
  }
  return read;
}

}  // namespace freelsd
