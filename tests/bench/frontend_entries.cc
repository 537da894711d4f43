// Stages of the frontend, and what one would write with OpenCV alone for each.
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

Contest Classification(const BenchScene& scene, const std::string& model_text) {
  const Classifier classifier = Classifier::Parse(model_text);
  const Segments segments = SegmentsOf(scene, 5);
  const cv::Mat image = scene.frames[5].image;
  return {"classification",
          SizeOf(image),
          [=, &scene] {
            Consume(ClassifySegments(segments, classifier, scene.options.classification)
                        .front()
                        .probability);
          },
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
              Consume(RegionFeatures(segments.image,
                                     segments.labels == segment.label,
                                     segments.ground_sampling_distance_m,
                                     FeatureSet::kPaper18)
                          .front());
            }
          },
          "12 Gabor filters of 9x9 and both colour spaces, whole image",
          [image] { Consume(PlainFeatures(image)); }};
}

Contest FollowTracks(const BenchScene& scene) {
  std::vector<cv::Mat1b> grey;
  for (const Frame& frame : scene.frames) grey.push_back(Grey(frame.image));
  const int num_corners = scene.options.tracks.max_num_corners;
  return {"tracks",
          SizeOf(scene.frames.front().image),
          [&scene] {
            Tracks tracks(scene.rig, scene.options.tracks);
            for (const Frame& frame : scene.frames) tracks.Add(frame);
            Consume(static_cast<double>(tracks.views().size()));
          },
          "goodFeaturesToTrack, calcOpticalFlowPyrLK there and back",
          [=] {
            for (size_t i = 1; i < grey.size(); ++i) {
              Consume(PlainTracks(grey[i - 1], grey[i], num_corners));
            }
          },
          static_cast<double>(scene.frames.size())};
}

// Per frame, with what the frontend has made of the earlier ones.
Contest ManageRegions(const BenchScene& scene, const std::string& model_text) {
  const auto tracks = std::make_shared<Tracks>(scene.rig, scene.options.tracks);
  const Classifier classifier = Classifier::Parse(model_text);
  std::vector<Segments> segments;
  std::vector<Labels> labels;
  for (size_t i = 0; i < scene.frames.size(); ++i) {
    tracks->Add(scene.frames[i]);
    segments.push_back(SegmentsOf(scene, i));
    labels.push_back(ClassifySegments(segments[i], classifier, scene.options.classification));
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

Contest WholeFrontend(const BenchScene& scene, const std::string& model_text) {
  const Classifier classifier = Classifier::Parse(model_text);
  const int num_corners = scene.options.tracks.max_num_corners;
  return {"frontend",
          SizeOf(scene.frames.front().image),
          [=, &scene] {
            Frontend frontend(scene.rig, scene.options, classifier);
            for (const Frame& frame : scene.frames) frontend.Process(frame);
            Consume(static_cast<double>(frontend.RankedRegions().size()));
          },
          "the plain ways of segmentation, classification and tracks together",
          [=, &scene] {
            for (size_t i = 0; i < scene.frames.size(); ++i) {
              const cv::Mat& image = scene.frames[i].image;
              Consume(PlainSegments(image)(0, 0) + PlainFeatures(image));
              if (i == 0) continue;
              Consume(PlainTracks(Grey(scene.frames[i - 1].image), Grey(image), num_corners));
            }
          },
          static_cast<double>(scene.frames.size())};
}

}  // namespace

std::vector<Entry> FrontendEntries(const std::string& model_text) {
  return {
      {"segmentation", [=] { return Segmentation(Scene(model_text)); }},
      {"classification", [=] { return Classification(Scene(model_text), model_text); }},
      {"features_paper18", [=] { return PaperFeatures(Scene(model_text)); }},
      {"tracks", [=] { return FollowTracks(Scene(model_text)); }},
      {"region_manager", [=] { return ManageRegions(Scene(model_text), model_text); }},
      {"frontend", [=] { return WholeFrontend(Scene(model_text), model_text); }},
  };
}

}  // namespace freelsd
