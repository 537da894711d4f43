#include "api/import/links/links.h"

#include <array>
#include <optional>
#include <utility>

#include "api/import/import.h"
#include "api/json_reader.h"

namespace freelsd {
namespace {

constexpr NumberRange kSystemIdRange{1.0, 255.0};
constexpr NumberRange kWindRange{-100.0, 100.0};
constexpr NumberRange kAgeRange{0.0, 1e9};

template <size_t kNum>
std::string ReadOneOf(const nlohmann::json& value,
                      const std::string& pointer,
                      const std::array<const char*, kNum>& words) {
  std::string word = ReadString(value, pointer);
  std::string known;
  for (const char* const each : words) {
    if (word == each) return word;
    known += (known.empty() ? "" : ", ") + std::string(each);
  }
  throw InvalidValue(pointer, pointer.substr(pointer.rfind('/') + 1) + ": must be one of " + known);
}

// One line for people.
std::string ReadLine(const nlohmann::json& value, const std::string& pointer) {
  std::string text = ReadString(value, pointer);
  const std::string name = pointer.substr(pointer.rfind('/') + 1);
  if (text.size() > kLimits.links.max_text_bytes) {
    throw InvalidValue(
        pointer,
        name + ": must have at most " + std::to_string(kLimits.links.max_text_bytes) + " bytes");
  }
  if (HasControlCharacter(text)) {
    throw InvalidValue(pointer, name + ": must have no control characters");
  }
  return text;
}

void CheckLine(ObjectReader& reader, const char* key) {
  if (const nlohmann::json* const value = reader.Find(key)) ReadLine(*value, reader.PointerTo(key));
}

void CheckPosition(const nlohmann::json& value) {
  ObjectReader reader(value, "/position");
  nlohmann::json point;
  for (const char* const key : {"latitude_deg", "longitude_deg", "altitude_m"}) {
    point[key] = reader.Required(key);
  }
  ReadGeoPoint(point, "/position");
  reader.Number("height_above_home_m");
  reader.Number("age_s", kAgeRange);
  CheckLine(reader, "altitude_datum");
}

void CheckWind(const nlohmann::json& value) {
  ObjectReader reader(value, "/wind");
  reader.RequiredNumber("east_mps", kWindRange);
  reader.RequiredNumber("north_mps", kWindRange);
  reader.Number("sd_mps", {0.0, 100.0});
  reader.Number("age_s", kAgeRange);
  CheckLine(reader, "source");
}

void CheckMission(const nlohmann::json& value) {
  ObjectReader reader(value, "/mission");
  ReadOneOf(
      reader.Required("state"), "/mission/state", std::array{"current", "uploading", "unknown"});
  CheckLine(reader, "site");
  CheckLine(reader, "kind");
  CheckLine(reader, "alarm");
}

void CheckEngine(const nlohmann::json& value) {
  ObjectReader reader(value, "/engine");
  ReadOneOf(reader.Required("state"), "/engine/state", std::array{"unknown", "running", "failed"});
  for (const char* const key : {"since", "reason", "declared_by"}) CheckLine(reader, key);
}

void CheckGuidance(const nlohmann::json& value) {
  ObjectReader reader(value, "/guidance");
  for (const char* const key : {"phase", "site_id", "since", "text"}) CheckLine(reader, key);
  for (const char* const key : {"arrival_margin_m", "told_margin_m", "eta_s"}) reader.Number(key);
}

std::string FlightIdOf(const nlohmann::json& value) {
  ObjectReader reader(value, "/flight");
  CheckLine(reader, "name");
  const nlohmann::json* const id = reader.Find("id");
  return id == nullptr ? std::string() : ReadLine(*id, "/flight/id");
}

const nlohmann::json& ReadList(const nlohmann::json& value,
                               const std::string& pointer,
                               size_t max_num) {
  if (!value.is_array() || value.size() > max_num) {
    throw InvalidValue(
        pointer, pointer.substr(1) + ": must be a list of at most " + std::to_string(max_num));
  }
  return value;
}

std::vector<LinkDecision> ReadDecisions(const nlohmann::json& list) {
  std::vector<LinkDecision> decisions;
  for (const nlohmann::json& entry : ReadList(list, "/log", kLimits.links.max_num_decisions)) {
    const std::string pointer = "/log/" + std::to_string(decisions.size());
    ObjectReader reader(entry, pointer);
    LinkDecision decision;
    decision.number = ReadInteger(reader.Required("id"), pointer + "/id");
    decision.at = ReadLine(reader.Required("at"), pointer + "/at");
    decision.text = ReadLine(reader.Required("text"), pointer + "/text");
    decision.kind = ReadLine(reader.Required("kind"), pointer + "/kind");
    if (!decisions.empty() && decision.number <= decisions.back().number) {
      throw InvalidValue(pointer + "/id", "id: must be greater than that of the line before");
    }
    decisions.push_back(std::move(decision));
  }
  return decisions;
}

CommandState StateOf(const std::string& name) {
  if (name == "done") return CommandState::kDone;
  return name == "failed" ? CommandState::kFailed : CommandState::kTaken;
}

std::vector<CommandReport> ReadCommands(const nlohmann::json& list) {
  std::vector<CommandReport> commands;
  for (const nlohmann::json& entry :
       ReadList(list, "/commands", kLimits.links.max_num_reported_commands)) {
    const std::string pointer = "/commands/" + std::to_string(commands.size());
    ObjectReader reader(entry, pointer);
    CommandReport command;
    command.id = ReadLine(reader.Required("id"), pointer + "/id");
    command.state = StateOf(ReadOneOf(
        reader.Required("state"), pointer + "/state", std::array{"taken", "done", "failed"}));
    if (const nlohmann::json* const detail = reader.Find("detail")) {
      command.detail = ReadLine(*detail, pointer + "/detail");
    }
    commands.push_back(std::move(command));
  }
  return commands;
}

// Members of the state itself, and those of its objects.
void CheckState(ObjectReader& reader) {
  reader.Number("system_id", kSystemIdRange);
  reader.Number("age_s", kAgeRange);
  for (const char* const key : {"type", "autopilot", "mode"}) CheckLine(reader, key);
  for (const char* const key : {"is_armed", "is_signed"}) {
    if (const nlohmann::json* const value = reader.Find(key)) {
      ReadBoolean(*value, reader.PointerTo(key));
    }
  }
  if (const nlohmann::json* const value = reader.Find("position")) CheckPosition(*value);
  if (const nlohmann::json* const value = reader.Find("wind")) CheckWind(*value);
  if (const nlohmann::json* const value = reader.Find("mission")) CheckMission(*value);
  if (const nlohmann::json* const value = reader.Find("engine")) CheckEngine(*value);
  if (const nlohmann::json* const value = reader.Find("guidance")) CheckGuidance(*value);
}

Eigen::Vector2d ReadPlannedWind(const nlohmann::json& value) {
  ObjectReader reader(value, "/wind");
  reader.RefuseKeysExcept({"east_mps", "north_mps"});
  return {reader.RequiredNumber("east_mps", kWindRange),
          reader.RequiredNumber("north_mps", kWindRange)};
}

std::string ReadConfirmedBy(ObjectReader& reader) {
  const nlohmann::json* const value = reader.Find("confirmed_by");
  return value == nullptr ? std::string() : ReadLine(*value, "/confirmed_by");
}

}  // namespace

const char* NameOf(CommandState state) {
  switch (state) {
    case CommandState::kQueued:
      return "queued";
    case CommandState::kExpired:
      return "expired";
    case CommandState::kTaken:
      return "taken";
    case CommandState::kDone:
      return "done";
    case CommandState::kFailed:
      return "failed";
  }
  return "failed";
}

LinkReport ParseLinkReport(const std::string& body) {
  LinkReport report;
  report.state = ParseJson(body, kLimits.links.max_bytes);
  ObjectReader reader(report.state, "");
  CheckState(reader);
  report.is_connected = ReadBoolean(reader.Required("is_connected"), "/is_connected");
  report.run = ReadLine(reader.Required("run"), "/run");
  if (report.run.empty()) throw InvalidValue("/run", "run: must not be empty");
  if (const nlohmann::json* const value = reader.Find("flight")) {
    report.flight_id = FlightIdOf(*value);
  }
  if (const nlohmann::json* const value = reader.Find("log")) {
    report.decisions = ReadDecisions(*value);
  }
  if (const nlohmann::json* const value = reader.Find("commands")) {
    report.commands = ReadCommands(*value);
  }
  report.state.erase("commands");
  return report;
}

CommandRequest ParseMissionRequest(const std::string& body) {
  const nlohmann::json object = ParseJson(body, kLimits.links.max_bytes);
  ObjectReader reader(object, "");
  reader.RefuseKeysExcept({"site_id", "wind", "confirmed_by"});
  CommandRequest request{"mission", ReadString(reader.Required("site_id"), "/site_id"), {}, {}};
  if (!IsValidId(request.site_id)) {
    throw InvalidValue("/site_id", "site_id: must match [A-Za-z0-9._-]{1,128}");
  }
  if (const nlohmann::json* const wind = reader.Find("wind")) {
    request.wind_in_world = ReadPlannedWind(*wind);
  }
  request.confirmed_by = ReadConfirmedBy(reader);
  return request;
}

CommandRequest ParseCommandRequest(const std::string& body, const std::string& kind) {
  CommandRequest request{kind, {}, {}, {}};
  if (body.empty()) return request;
  const nlohmann::json object = ParseJson(body, kLimits.links.max_bytes);
  ObjectReader reader(object, "");
  reader.RefuseKeysExcept({"confirmed_by"});
  request.confirmed_by = ReadConfirmedBy(reader);
  return request;
}

}  // namespace freelsd
