#include "api/export/report/page.h"

#include <algorithm>
#include <cctype>

#include "api/export/text.h"

namespace freelsd {
namespace {

constexpr char kStyle[] =
    "body{font:16px/1.4 sans-serif;max-width:60em;margin:1em auto;padding:0 1em;color:#111;"
    "background:#fff}h1{font-size:1.5em}.verdict{padding:.6em 1em;border:3px "
    "solid;font-weight:bold}"
    ".landable{border-color:#0072b2}.unverified{border-color:#e69f00}.rejected{border-color:#"
    "d55e00}"
    "table{border-collapse:collapse}th,td{text-align:left;vertical-align:top;"
    "padding:.2em .8em .2em 0;border-bottom:1px "
    "solid #ccc}figure{margin:.5em 0;break-inside:avoid}.layers{display:grid;gap:1em;"
    "grid-template-columns:repeat(auto-fit,minmax(16em,1fr))}svg{width:100%;max-height:40em;"
    "background:#f4f4f4}figcaption img{display:block}image{image-rendering:pixelated}"
    "image.photo{image-rendering:auto}"
    "polyline,path{fill:none;vector-effect:non-scaling-stroke}.casing{stroke:#fff;stroke-width:5}"
    ".circle,.final{stroke:#000;stroke-width:2.5}.circle{stroke-dasharray:8 5}"
    ".final{stroke-dasharray:1 0}.strip{stroke:#000;stroke-width:1.5}"
    ".terrain{stroke:#8c510a;stroke-width:2.5}"
    ".touchdown{fill:#000;stroke:#fff;stroke-width:2;vector-effect:non-scaling-stroke}"
    ".label{paint-order:stroke;stroke:#fff;stroke-width:.25em;stroke-linejoin:round}"
    ".axis,.scale{stroke:#000;stroke-width:2}.unseen{fill:#ccc}";

bool BeginsWithVerdict(const std::string& summary, const std::string& verdict) {
  return summary.size() >= verdict.size() &&
         std::equal(verdict.begin(), verdict.end(), summary.begin(), [](char a, char b) {
           return a == std::tolower(static_cast<unsigned char>(b));
         });
}

}  // namespace

std::string PageOf(const std::string& title,
                   const std::string& more_style,
                   const std::string& body) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><title>" +
         EscapeXml(title) +
         "</title><meta name=\"viewport\" content=\"width=device-width\"/><style>" + kStyle +
         more_style + "</style></head><body>\n" + body + "</body></html>\n";
}

std::string Row(const std::string& label, const std::string& value) {
  return "<tr><th scope=\"row\">" + label + "</th><td>" + value + "</td></tr>\n";
}

std::string Table(const std::string& rows) { return "<table>\n" + rows + "</table>\n"; }

std::string ColumnTable(const std::vector<std::string>& head,
                        const std::vector<std::vector<std::string>>& rows) {
  std::string text = "<table class=\"wide\">\n<thead><tr>";
  for (const std::string& name : head) text += "<th scope=\"col\">" + name + "</th>";
  text += "</tr></thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    text += "<tr>";
    for (const std::string& cell : row) text += "<td>" + cell + "</td>";
    text += "</tr>\n";
  }
  return text + "</tbody></table>\n";
}

std::string VerdictOf(const StoredSite& site) {
  return site.IsRejected() ? "rejected" : site.verdict;
}

// The word stands in the text: a print in black and white has no colour.
std::string VerdictBox(const StoredSite& site) {
  const std::string verdict = VerdictOf(site);
  const std::string summary = site.summary.value_or("");
  const std::string word = BeginsWithVerdict(summary, verdict) ? "" : verdict + ". ";
  return "<p class=\"verdict " + verdict + "\">" + word + EscapeXml(summary) + "</p>\n";
}

}  // namespace freelsd
