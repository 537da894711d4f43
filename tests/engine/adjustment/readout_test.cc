// What a rolling shutter does to a block, and what the images show of it.
#include <algorithm>
#include <stdexcept>

#include <doctest/doctest.h>

#include "engine/adjustment/adjustment.h"
#include "tests/engine/adjustment/survey.h"

namespace freelsd {
namespace {

TEST_CASE(
    "adjustment: what a rolling shutter does to each image is found, not bent into the poses") {
  SurveyOptions options;
  options.gps_sd_m = 0.5;
  options.outlier_ratio = 0.0;
  options.readout_turn = 0.02;
  Survey survey = MakeSurvey(options);
  const AdjustedBlock taken_for_global = AdjustPoses(survey.views, survey.camera, {});
  CHECK(taken_for_global.rms_after_px > 1.5 * kMaxRmsPx);
  survey.camera.readout_s = 0.2;
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(block.is_usable);
  CHECK(block.rms_after_px < kMaxRmsPx);
  CHECK(CompareWithTruth(survey, block).max_attitude_deg <
        0.6 * CompareWithTruth(survey, taken_for_global).max_attitude_deg);
}

TEST_CASE("adjustment: an uneven turn while the rows are read is found too") {
  SurveyOptions options;
  options.gps_sd_m = 0.5;
  options.outlier_ratio = 0.0;
  options.readout_turn = 0.02;
  options.readout_bend = 0.06;
  Survey survey = MakeSurvey(options);
  survey.camera.readout_s = 0.2;
  AdjustmentOptions even;
  even.readout_change_sd_deg_s2 = 0.01;
  CHECK(AdjustPoses(survey.views, survey.camera, even).rms_after_px > 1.3 * kMaxRmsPx);
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(block.is_usable);
  CHECK(block.rms_after_px < kMaxRmsPx);
}

const ParameterEvidence* EvidenceOf(const AdjustedBlock& block, const std::string& name) {
  for (const ParameterEvidence& each : block.evidence) {
    if (each.name == name) return &each;
  }
  return nullptr;
}

SurveyOptions GustySurvey() {
  SurveyOptions options;
  options.gps_sd_m = 0.5;
  options.outlier_ratio = 0.0;
  options.readout_turn = 0.02;
  options.readout_bend = 0.06;
  return options;
}

TEST_CASE("adjustment: gusts while the rows are read are found, and each power says its gain") {
  SurveyOptions options = GustySurvey();
  options.readout_gust = 0.02;
  Survey survey = MakeSurvey(options);
  survey.camera.readout_s = 0.2;
  AdjustmentOptions quadratic;
  quadratic.max_readout_power = 2;
  const AdjustedBlock bent = AdjustPoses(survey.views, survey.camera, quadratic);
  CHECK(bent.rms_after_px > 1.3 * kMaxRmsPx);
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(block.is_usable);
  CHECK(block.rms_after_px < kMaxRmsPx);
  CHECK(CompareWithTruth(survey, block).max_attitude_deg <
        0.5 * CompareWithTruth(survey, bent).max_attitude_deg);
  CHECK(block.EvidenceNote().find("readout.turn^3 kept: ") == 0);
  for (const char* name : {"readout.turn^3", "readout.turn^4", "readout.turn^5"}) {
    CAPTURE(name);
    REQUIRE(EvidenceOf(block, name));
    CHECK(EvidenceOf(block, name)->is_kept);
    CHECK(EvidenceOf(block, name)->gain > 0.0);
    // 1.1 deg of each power. A power that is tried first takes a part of the next ones.
    CHECK(EvidenceOf(block, name)->turn_deg > 0.7);
    CHECK(EvidenceOf(block, name)->turn_deg < 3.0);
  }
}

TEST_CASE("adjustment: wrong matches of a few pixels are dropped by the block's own deviation") {
  SurveyOptions options;
  options.gps_sd_m = 0.5;
  options.outlier_ratio = 0.0;
  Survey survey = MakeSurvey(options);
  // Eight deviations, but within the fixed limit.
  for (View& view : survey.views) {
    for (size_t i = 0; i < view.observations.size(); i += 25) {
      view.observations[i].point_in_image += 8.0 * kNoisePx * Eigen::Vector2d::UnitX();
    }
  }
  AdjustmentOptions fixed_limit;
  fixed_limit.max_reprojection_error_sigma = 100.0;
  CHECK(AdjustPoses(survey.views, survey.camera, fixed_limit).rms_after_px > kMaxRmsPx);
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  CHECK(NumConnected(block) == static_cast<int>(survey.views.size()));
  CHECK(block.rms_after_px < kMaxRmsPx);
}

TEST_CASE("adjustment: powers of the turn that the images do not show are not kept") {
  Survey survey = MakeSurvey(GustySurvey());
  survey.camera.readout_s = 0.2;
  const AdjustedBlock block = AdjustPoses(survey.views, survey.camera, {});
  REQUIRE(EvidenceOf(block, "readout.turn^3"));
  CHECK_FALSE(EvidenceOf(block, "readout.turn^3")->is_kept);
  CHECK(EvidenceOf(block, "readout.turn^3")->gain < 0.0);
  CHECK_FALSE(EvidenceOf(block, "readout.turn^4"));
  for (const AdjustedView& view : block.views) {
    CHECK(view.readout.turns.rightCols<3>().isZero(0.0));
  }
}

TEST_CASE("adjustment: a readout that nobody stated is kept where images show it, and only there") {
  SurveyOptions options;
  options.gps_sd_m = 0.5;
  options.num_points = 700;
  options.outlier_ratio = 0.02;
  const auto block_of = [&](double readout_turn) {
    options.readout_turn = readout_turn;
    Survey survey = MakeSurvey(options);
    survey.camera.source = CameraSource::kExif;
    return AdjustPoses(survey.views, survey.camera, {});
  };
  const auto is_global = [](const AdjustedView& view) { return view.readout.IsGlobal(); };
  const AdjustedBlock rolling = block_of(0.005);
  CHECK(std::none_of(rolling.views.begin(), rolling.views.end(), is_global));
  CHECK(rolling.rms_after_px < kMaxRmsPx);
  const AdjustedBlock still = block_of(0.0);
  CHECK(std::all_of(still.views.begin(), still.views.end(), is_global));
  CHECK(still.rms_after_px < kMaxRmsPx);
}

}  // namespace
}  // namespace freelsd
