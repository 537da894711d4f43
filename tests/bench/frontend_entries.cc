// Stages of the frontend, and what one would write with OpenCV alone for each.
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "tests/bench/bench_scene.h"
#include "tests/bench/contest.h"

namespace freelsd {
namespace {

cv::Mat1b Grey(const cv::Mat& image) {
  cv::Mat1b grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// Sec. III-C with the calls that it names, on the whole image.
cv::Mat1i PlainSegments(const cv::Mat& image) {
  constexpr double kCannyHigh = 120.0;
  constexpr double kMinEdgeDistancePx = 9.0;  // 2 m from 100 m with 465 px
  cv::Mat1b edges;
  cv::Canny(Grey(image), edges, kCannyHigh / 3.0, kCannyHigh);
  cv::Mat1f distance;
  cv::distanceTransform(255 - edges, distance, cv::DIST_L2, cv::DIST_MASK_5);
  cv::Mat1i labels;
  cv::connectedComponents(distance > kMinEdgeDistancePx, labels, 8, CV_32S);
  return labels;
}

// The paper's twelve filters on the whole image, and the statistics of both colour spaces.
double PlainFeatures(const cv::Mat& image) {
  constexpr int kKernelPx = 9;
  constexpr double kSigma = 4.0, kAspect = 0.02;
  const cv::Mat1b grey = Grey(image);
  double sum = 0.0;
  cv::Scalar mean, deviation;
  for (const double wavelength : {0.5, 1.0, 5.0}) {
    for (int i = 0; i < 4; ++i) {
      const cv::Mat kernel = cv::getGaborKernel(
          {kKernelPx, kKernelPx}, kSigma, 0.25 * CV_PI * i, wavelength, kAspect, 0.0, CV_32F);
      cv::Mat response;
      cv::filter2D(grey, response, CV_32F, kernel);
      cv::meanStdDev(response, mean, deviation);
      sum += mean[0] + deviation[0];
    }
  }
  cv::Mat hsv;
  cv::cvtColor(image, hsv, cv::COLOR_BGR2HSV);
  for (const cv::Mat& space : {image, hsv}) {
    cv::meanStdDev(space, mean, deviation);
    sum += mean[0] + deviation[0];
  }
  return sum;
}

// Corners of the first image, followed to the second and back.
double PlainTracks(const cv::Mat1b& first, const cv::Mat1b& second, int num_corners) {
  constexpr double kQuality = 0.01, kMinDistancePx = 8.0;
  std::vector<cv::Point2f> corners, forward, backward;
  cv::goodFeaturesToTrack(first, corners, num_corners, kQuality, kMinDistancePx);
  std::vector<uchar> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(first, second, corners, forward, status, error);
  cv::calcOpticalFlowPyrLK(second, first, forward, backward, status, error);
  return backward.empty() ? 0.0 : backward.front().x;
}

Segments SegmentsOf(const BenchScene& scene, size_t frame) {
  return SegmentFrame(
      scene.frames[frame].image, scene.rig.camera, kBenchHeightM, scene.options.segmentation);
}

Contest Segmentation(const BenchScene& scene) {
  const cv::Mat image = scene.frames[5].image;
  return {"segmentation",
          SizeOf(image),
          [&scene] { Consume(static_cast<double>(SegmentsOf(scene, 5).segments.size())); },
          "Canny, distance transform, threshold, components at full size",
          [image] { Consume(PlainSegments(image)(0, 0)); }};
}

std::shared_ptr<KindNetwork> NetworkIn(const std::string& model_file) {
  return std::make_shared<KindNetwork>(std::get<KindModel>(ReadGroundModel(model_file).model));
}

Contest Kinds(const BenchScene& scene, const std::string& model_file) {
  const auto network = NetworkIn(model_file);
  const cv::Mat image = scene.frames[5].image;
  const double sampling_m = kBenchHeightM / scene.rig.camera.MeanFocalPx();
  return {"ground_kind",
          SizeOf(image),
          [=] { Consume(network->Tell(image, sampling_m).grass(0, 0)); },
          "12 Gabor filters of 9x9 and both colour spaces, whole image",
          [image] { Consume(PlainFeatures(image)); }};
}

// The paper's features, region by region.
Contest PaperFeatures(const BenchScene& scene) {
  const Segments segments = SegmentsOf(scene, 5);
  const cv::Mat image = scene.frames[5].image;
  return {"features_paper18",
          SizeOf(image),
          [segments] {
            for (const Segment& segment : segments.segments) {
              Consume(RegionFeatures(
                          segments.image, segments.labels == segment.label, FeatureSet::kPaper18)
                          .front());
            }
          },
          "12 Gabor filters of 9x9 and both colour spaces, whole image",
          [image] { Consume(PlainFeatures(image)); }};
}

// As they are in flight: the ground's height is known, so corners are followed from the start.
std::vector<Frame> FramesInFlight(const BenchScene& scene) {
  std::vector<Frame> frames = scene.frames;
  for (Frame& frame : frames) frame.height_above_ground = kBenchHeightM;
  return frames;
}

// The leap to the next leg is matched by descriptors, which have a row of their own.
std::vector<Frame> FramesOfLeg(const BenchScene& scene) {
  std::vector<Frame> leg = FramesInFlight(scene);
  leg.resize(kNumFramesOfLeg);
  return leg;
}

Contest FollowTracks(const BenchScene& scene) {
  const std::vector<Frame> leg = FramesOfLeg(scene);
  std::vector<cv::Mat1b> grey;
  grey.reserve(leg.size());
  for (const Frame& frame : leg) grey.push_back(Grey(frame.image));
  const int num_corners = scene.options.tracks.max_num_corners;
  return {"tracks",
          SizeOf(scene.frames.front().image),
          [&scene, leg] {
            Tracks tracks(scene.rig, scene.options.tracks);
            for (const Frame& frame : leg) tracks.Add(frame);
            Consume(static_cast<double>(tracks.views().size()));
          },
          "goodFeaturesToTrack, calcOpticalFlowPyrLK there and back",
          [=] {
            for (size_t i = 1; i < grey.size(); ++i) {
              Consume(PlainTracks(grey[i - 1], grey[i], num_corners));
            }
          },
          kNumFramesOfLeg - 1.0};
}

// SIFT on every image, and its nearest neighbours among the image before by brute force.
double PlainDescriptors(const std::vector<cv::Mat1b>& grey, int num_keypoints) {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(num_keypoints);
  const cv::BFMatcher matcher(cv::NORM_L2, true);
  cv::Mat previous;
  double sum = 0.0;
  for (const cv::Mat1b& image : grey) {
    std::vector<cv::KeyPoint> keypoints;
    cv::Mat descriptors;
    sift->detectAndCompute(image, {}, keypoints, descriptors);
    std::vector<cv::DMatch> matches;
    if (!previous.empty()) matcher.match(previous, descriptors, matches);
    previous = descriptors;
    sum += static_cast<double>(matches.size());
  }
  return sum;
}

// Survey photographs: each against its predecessor and up to six neighbours.
Contest MatchDescriptorsOfSurvey(const BenchScene& scene) {
  std::vector<cv::Mat1b> grey;
  for (const Frame& frame : scene.frames) grey.push_back(Grey(frame.image));
  TracksOptions options = scene.options.tracks;
  options.max_klt_flow_ratio = 0.0;
  return {"descriptors",
          SizeOf(scene.frames.front().image),
          [&scene, options, frames = FramesInFlight(scene)] {
            Tracks tracks(scene.rig, options);
            for (const Frame& frame : frames) tracks.Add(frame);
            Consume(static_cast<double>(tracks.views().size()));
          },
          "SIFT and BFMatcher with the image before, no verification",
          [grey, options] { Consume(PlainDescriptors(grey, options.max_num_keypoints)); },
          static_cast<double>(scene.frames.size())};
}

// Per frame, with what the frontend has made of the earlier ones.
Contest ManageRegions(const BenchScene& scene, const std::string& model_file) {
  const auto tracks = std::make_shared<Tracks>(scene.rig, scene.options.tracks);
  const auto network = NetworkIn(model_file);
  const double sampling_m = kBenchHeightM / scene.rig.camera.MeanFocalPx();
  std::vector<Segments> segments;
  std::vector<Labels> labels;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    tracks->Add(scene.frames[i]);
    segments.push_back(SegmentsOf(scene, i));
    labels.push_back(LabelsOf(segments[i],
                              network->Tell(scene.frames[i].image, sampling_m),
                              scene.options.classification));
  }
  tracks->Flush();
  const size_t num_views = tracks->views().size();
  return {"region_manager",
          SizeOf(scene.frames.front().image),
          [=, &scene] {
            Regions regions(scene.options.regions);
            for (size_t i = 0; i < num_views; ++i) {
              regions.Update(i, segments[i], labels[i], *tracks);
            }
            Consume(static_cast<double>(regions.Ranked().size()));
          },
          "",
          {},
          static_cast<double>(num_views)};
}

Contest WholeFrontend(const BenchScene& scene, const std::string& model_file) {
  const GroundModel ground_model = ReadGroundModel(model_file).model;
  const std::vector<Frame> leg = FramesOfLeg(scene);
  const int num_corners = scene.options.tracks.max_num_corners;
  return {"frontend",
          SizeOf(scene.frames.front().image),
          [=, &scene] {
            Frontend frontend(scene.rig, scene.options, ground_model);
            for (const Frame& frame : leg) frontend.Process(frame);
            Consume(static_cast<double>(frontend.RankedRegions().size()));
          },
          "the plain ways of segmentation, classification and tracks together",
          [=] {
            for (size_t i = 0; i < leg.size(); ++i) {
              const cv::Mat& image = leg[i].image;
              Consume(PlainSegments(image)(0, 0) + PlainFeatures(image));
              if (i == 0) continue;
              Consume(PlainTracks(Grey(leg[i - 1].image), Grey(image), num_corners));
            }
          },
          kNumFramesOfLeg};
}

// Survey photographs, whose poses are refined as they arrive.
Contest SurveyFrontend(const BenchScene& scene, const std::string& model_file) {
  const GroundModel ground_model = ReadGroundModel(model_file).model;
  PipelineOptions options = scene.options;
  options.tracks.max_klt_flow_ratio = 0.0;
  return {"survey_frontend",
          SizeOf(scene.frames.front().image),
          [=, &scene, frames = FramesInFlight(scene)] {
            Frontend frontend(scene.rig, options, ground_model);
            for (const Frame& frame : frames) frontend.Process(frame);
            Consume(static_cast<double>(frontend.RankedRegions().size()));
          },
          "",
          {},
          static_cast<double>(scene.frames.size())};
}

// A photograph of 12 megapixels from its JPEG to labelled regions; joining it with others is the
// row of descriptors.
Contest Photograph(const BenchScene& scene, const std::string& model_file) {
  const auto network = NetworkIn(model_file);
  constexpr int kWidthPx = 4000;
  const double scale = static_cast<double>(kWidthPx) / scene.rig.camera.width_px;
  const Camera camera = scene.rig.camera.Scaled(scale);
  cv::Mat large;
  cv::resize(scene.frames[5].image,
             large,
             cv::Size(camera.width_px, camera.height_px),
             0.0,
             0.0,
             cv::INTER_CUBIC);
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", large, jpeg);
  return {"photograph",
          SizeOf(large),
          [=, &scene] {
            const cv::Mat image = cv::imdecode(jpeg, cv::IMREAD_COLOR);
            const Segments segments =
                SegmentFrame(image, camera, kBenchHeightM, scene.options.segmentation);
            const KindPicture kinds = network->Tell(image, kBenchHeightM / camera.MeanFocalPx());
            Consume(static_cast<double>(
                LabelsOf(segments, kinds, scene.options.classification).size()));
          },
          "imdecode alone",
          [jpeg] { Consume(cv::imdecode(jpeg, cv::IMREAD_COLOR).rows); }};
}

}  // namespace

std::vector<Entry> FrontendEntries(const std::string& model_file) {
  return {
      {"segmentation", [=] { return Segmentation(Scene(model_file)); }},
      {"ground_kind", [=] { return Kinds(Scene(model_file), model_file); }},
      {"features_paper18", [=] { return PaperFeatures(Scene(model_file)); }},
      {"tracks", [=] { return FollowTracks(Scene(model_file)); }},
      {"descriptors", [=] { return MatchDescriptorsOfSurvey(Scene(model_file)); }},
      {"region_manager", [=] { return ManageRegions(Scene(model_file), model_file); }},
      {"frontend", [=] { return WholeFrontend(Scene(model_file), model_file); }},
      {"survey_frontend", [=] { return SurveyFrontend(Scene(model_file), model_file); }},
      {"photograph", [=] { return Photograph(Scene(model_file), model_file); }},
  };
}

}  // namespace freelsd
