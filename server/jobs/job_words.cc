#include "server/jobs/job_words.h"

#include <cmath>

namespace freelsd {
namespace {

struct Title {
  const char* stage;
  const char* title;
};

// Every stage of a job. The engine names those of an evaluation.
constexpr Title kTitles[] = {
    {"", "Starting"},
    {"frontend", "Looking for fields in the photographs"},
    {"adjustment", "Working out where the photographs were taken"},
    {"stereo", "Comparing pairs of photographs"},
    {"hazards", "Judging the ground"},
    {"approach", "Planning approaches"},
    {"picture", "Drawing the picture of the ground"},
};

int RoundTo(double number, int step) { return static_cast<int>(std::lround(number / step)) * step; }

}  // namespace

std::string StageTitle(const std::string& stage) {
  for (const Title& each : kTitles) {
    if (stage == each.stage) return each.title;
  }
  return stage;
}

std::string AboutTime(double seconds) {
  constexpr double kMinute = 60.0;
  constexpr double kHour = 3600.0;
  if (!(seconds >= 4.0)) return "a few seconds";
  if (seconds < 97.5) return "about " + std::to_string(RoundTo(seconds, 5)) + " s";
  if (seconds < 99.5 * kMinute) {
    return "about " + std::to_string(RoundTo(seconds / kMinute, 1)) + " min";
  }
  return "about " + std::to_string(RoundTo(seconds / kHour, 1)) + " h";
}

}  // namespace freelsd
