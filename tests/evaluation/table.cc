#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "tests/evaluation/report.h"

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr int kNameWidth = 36;

std::string Text(const Json& value) {
  if (value.is_null()) return "-";
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_number_float()) return value.dump();
  std::ostringstream text;
  text << std::setprecision(4) << value.get<double>();
  return text.str();
}

// `name  value` for numbers and `name  key value, key value` for what is counted by name.
void WritePart(std::ostringstream& out, const std::string& title, const Json& part) {
  out << title << "\n";
  for (const auto& [name, value] : part.items()) {
    if (value.is_object() && !value.empty() && value.begin()->is_object()) continue;
    out << "  " << std::left << std::setw(kNameWidth) << name;
    if (!value.is_object()) {
      out << Text(value) << "\n";
      continue;
    }
    std::string line;
    for (const auto& [key, number] : value.items()) {
      line += (line.empty() ? "" : "; ") + key + " " + Text(number);
    }
    out << (line.empty() ? "-" : line) << "\n";
  }
}

// One row per name, one column per number.
void WriteRows(std::ostringstream& out, const std::string& title, const Json& rows) {
  if (rows.empty()) return;
  out << title << "\n";
  bool is_first = true;
  constexpr int kColumnWidth = 20;
  size_t name_width = kColumnWidth;
  for (const auto& [name, row] : rows.items()) name_width = std::max(name_width, name.size() + 2);
  for (const auto& [name, row] : rows.items()) {
    if (is_first) {
      out << "  " << std::left << std::setw(static_cast<int>(name_width)) << "";
      for (const auto& [column, value] : row.items()) out << std::setw(kColumnWidth) << column;
      out << "\n";
    }
    is_first = false;
    out << "  " << std::left << std::setw(static_cast<int>(name_width)) << name;
    for (const auto& [column, value] : row.items()) out << std::setw(kColumnWidth) << Text(value);
    out << "\n";
  }
}

std::string Joined(const Json& names) {
  std::string joined;
  for (const Json& name : names) joined += (joined.empty() ? "" : ", ") + name.get<std::string>();
  return joined;
}

void WritePlans(std::ostringstream& out, const Json& report) {
  WritePart(out, "safety", report.at("safety"));
  WriteRows(out,
            "sites, by what the ground at the touchdown truly is",
            report.at("safety").at("sites_by_ground"));
  if (report.at("safety_by_spacing").size() > 1) {
    WriteRows(out, "sites, by the spacing of the photographs", report.at("safety_by_spacing"));
  }
  WritePart(out, "flown, 200 times to each accepted site", report.at("flown"));
  WriteRows(out, "landings drawn at random, by their expected risk", report.at("landing_risks"));
  WritePart(out, "found, of what the planner accepts on maps without error", report.at("found"));
  WriteRows(out, "fields, by their clear touchdowns", report.at("found").at("by_room"));
  WriteRows(out,
            "fields, by the share of disc, roll and final that was photographed",
            report.at("found").at("by_photographed_ratio"));
}

void WriteHeights(std::ostringstream& out, const Json& heights) {
  if (heights.empty()) return;
  WritePart(out, "heights of open ground that three photographs see", heights);
  WriteRows(out, "heights, far from and near what is tall", heights.at("by_place"));
  WriteRows(out, "heights, by the deviation that is told", heights.at("by_told_deviation"));
  if (heights.at("by_spacing").size() > 1) {
    WriteRows(out, "heights, by the spacing of the photographs", heights.at("by_spacing"));
  }
}

void WriteSeconds(std::ostringstream& out, const std::string& title, const Json& seconds) {
  std::string parts;
  for (const auto& [part, value] : seconds.items()) {
    parts += (parts.empty() ? "" : "; ") + part + " " + Text(value);
  }
  out << title << ": " << parts << "\n";
}

}  // namespace

std::string TableOf(const Json& report) {
  std::ostringstream out;
  const Json& settings = report.at("settings");
  if (settings.contains("given")) out << "given: the true " << Joined(settings.at("given")) << "\n";
  const bool has_plans = report.contains("safety");
  if (has_plans) WritePlans(out, report);
  WritePart(out, "maps", report.at("maps"));
  WriteHeights(out, report.at("heights"));
  if (has_plans) {
    WriteRows(out, "things, by kind, width and height in metres", report.at("things"));
    WriteRows(
        out, "the map made wrong on purpose, planned on in the same places", report.at("blinded"));
    WriteRows(out, "steps left out in turn", report.at("ablations"));
  }
  WriteRows(out, "cells of the map, by what they truly are", report.at("maps").at("kinds"));
  if (has_plans) {
    WritePart(out, "frontend", report.at("frontend"));
    WriteRows(
        out, "pixels of the masks, by what they truly show", report.at("frontend").at("covers"));
  }
  WritePart(out, "poses", report.at("poses"));
  WriteSeconds(out, "processor seconds per world", report.at("cpu_s_per_world"));
  WriteSeconds(out, "seconds per world, by stage", report.at("stage_s_per_world"));
  out << "peak memory, with the world: " << Text(report.at("peak_memory_with_world_mib"))
      << " MiB\n";
  return out.str();
}

}  // namespace freelsd
