// What runs now, and what is learned from what ran.
#include "server/jobs/progress_board.h"

#include <thread>

#include <doctest/doctest.h>

#include "server/jobs/job_words.h"

namespace freelsd {
namespace {

TEST_CASE("progress board: an evaluation is there from its beginning to its end, with its area") {
  ProgressBoard board;
  CHECK_FALSE(board.Evaluating());
  CHECK_FALSE(board.TimingOf("j-1"));
  {
    const EvaluationMark mark(board, EvaluationKind::kFinish, "f-1", "j-1", 24);
    board.SetArea("{}");
    REQUIRE(board.Evaluating());
    CHECK(board.Evaluating()->flight_id == "f-1");
    CHECK(board.Evaluating()->job_id == "j-1");
    CHECK(board.Evaluating()->area_json == "{}");
    // Nothing was measured yet.
    CHECK_FALSE(board.Evaluating()->time_left_s);
    CHECK(board.TimingOf("j-1")->started_at_us > 0);
  }
  CHECK_FALSE(board.Evaluating());
  CHECK(board.TimingOf("j-1"));
  CHECK_FALSE(board.TimingOf("j-1")->time_left_s);
}

TEST_CASE(
    "progress board: only complete evaluations tell how long others take, each kind by itself") {
  ProgressBoard board;
  { const EvaluationMark cancelled(board, EvaluationKind::kFinish, "f-1", "j-1", 10); }
  CHECK_FALSE(board.ExpectedEvaluationS(EvaluationKind::kFinish, 10));
  {
    EvaluationMark mark(board, EvaluationKind::kFinish, "f-1", "j-2", 10);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    mark.is_complete = true;
  }
  const auto expected_s = board.ExpectedEvaluationS(EvaluationKind::kFinish, 20);
  REQUIRE(expected_s);
  CHECK(*expected_s >= 0.04);
  CHECK_FALSE(board.ExpectedEvaluationS(EvaluationKind::kPeriodic, 20));
  // The next one is expected to take as long.
  const EvaluationMark next(board, EvaluationKind::kFinish, "f-2", "j-3", 20);
  CHECK(board.Evaluating()->time_left_s.value() <= *expected_s);
  CHECK(board.TimingOf("j-3")->time_left_s.value() <= *expected_s);
}

TEST_CASE("progress board: a batch begins with its first progress, and old jobs are forgotten") {
  ProgressBoard board;
  board.TellBatch("j-1", 0.0);
  CHECK_FALSE(board.TimingOf("j-1"));
  board.TellBatch("j-1", 0.1);
  CHECK(board.TimingOf("j-1"));
  for (int i = 0; i < 2000; ++i) board.TellBatch("other-" + std::to_string(i), 0.5);
  CHECK_FALSE(board.TimingOf("j-1"));
  CHECK(board.TimingOf("other-1999"));
}

TEST_CASE("job words: times are rounded as people say them") {
  CHECK(AboutTime(0.0) == "a few seconds");
  CHECK(AboutTime(23.0) == "about 25 s");
  CHECK(AboutTime(97.0) == "about 95 s");
  CHECK(AboutTime(98.0) == "about 2 min");
  CHECK(AboutTime(40 * 60.0) == "about 40 min");
  CHECK(AboutTime(100 * 60.0) == "about 2 h");
  CHECK(StageTitle("stereo") == "Comparing pairs of photographs");
  CHECK(StageTitle("a new stage") == "a new stage");
}

}  // namespace
}  // namespace freelsd
