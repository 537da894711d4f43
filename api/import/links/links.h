// What a link to an autopilot reports: bytes -> its state. Treats its input as hostile.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/api.h"

namespace freelsd {

// A decision of the link, for people. Numbers ascend within one run of the link's program.
struct LinkDecision {
  int64_t number = 0;
  std::string at;
  std::string kind;
  std::string text;
};

enum class CommandState { kQueued, kExpired, kTaken, kDone, kFailed };
const char* NameOf(CommandState state);

// What became of a command.
struct CommandReport {
  std::string id;
  CommandState state = CommandState::kTaken;
  std::string detail;
};

// NOLINTNEXTLINE(bugprone-exception-escape): an empty json throws nothing.
struct LinkReport {
  // The body without `commands`.
  nlohmann::json state;
  // Random text that differs for each start of the link's program.
  std::string run;
  // Empty while the link has no flight.
  std::string flight_id;
  bool is_connected = false;
  // In ascending order.
  std::vector<LinkDecision> decisions;
  std::vector<CommandReport> commands;
};

// What a person asks of an aircraft.
struct CommandRequest {
  // mission, engine_failure or release.
  std::string kind;
  // Of a mission; otherwise empty.
  std::string site_id;
  // Who asked; empty if not given.
  std::string confirmed_by;
  // East and north, m/s: of a mission, the wind that the confirmed approach is planned for.
  std::optional<Eigen::Vector2d> wind_in_world;
};

// Members that people or programs rely on must have their type and range; others are kept as they
// are. Throws ApiError.
LinkReport ParseLinkReport(const std::string& body);
// {site_id, wind?, confirmed_by?}. Throws ApiError.
CommandRequest ParseMissionRequest(const std::string& body);
// {confirmed_by?}, or empty. Throws ApiError.
CommandRequest ParseCommandRequest(const std::string& body, const std::string& kind);

}  // namespace freelsd
