#include "engine/tracks/descriptor_matching.h"

#include <algorithm>
#include <random>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr int kNumEntries = 128;

cv::Mat RandomDescriptors(int count, unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat descriptors(count, kNumEntries, CV_8U);
  for (int i = 0; i < count * kNumEntries; ++i) {
    descriptors.data[i] = static_cast<uchar>(random() % 80);
  }
  return descriptors;
}

// Rows of `from` in another order, each entry off by up to `noise`.
cv::Mat Shuffled(const cv::Mat& from, const std::vector<int>& order, int noise) {
  std::mt19937 random(7);
  cv::Mat to(static_cast<int>(order.size()), kNumEntries, CV_8U);
  for (int row = 0; row < to.rows; ++row) {
    for (int i = 0; i < kNumEntries; ++i) {
      const int change = static_cast<int>(random() % (2U * noise + 1U)) - noise;
      to.at<uchar>(row, i) =
          cv::saturate_cast<uchar>(from.at<uchar>(order[static_cast<size_t>(row)], i) + change);
    }
  }
  return to;
}

std::vector<int> ReversedOrder(int count) {
  std::vector<int> order;
  for (int i = count - 1; i >= 0; --i) order.push_back(i);
  return order;
}

TEST_CASE("descriptors are found again in another order, whatever their number") {
  for (const int count : {2, 3, 15, 16, 17, 61}) {
    CAPTURE(count);
    const cv::Mat a = RandomDescriptors(count, 1);
    const std::vector<IndexPair> matches =
        MatchDescriptors(a, Shuffled(a, ReversedOrder(count), 4));
    REQUIRE(static_cast<int>(matches.size()) == count);
    for (const IndexPair& match : matches) CHECK(match.b == count - 1 - match.a);
  }
}

TEST_CASE("a descriptor with a twin is not matched") {
  const cv::Mat a = RandomDescriptors(20, 1);
  std::vector<int> order = ReversedOrder(20);
  order.push_back(5);
  const std::vector<IndexPair> matches = MatchDescriptors(a, Shuffled(a, order, 1));
  CHECK(matches.size() == 19);
  for (const IndexPair& match : matches) CHECK(match.a != 5);
}

TEST_CASE("descriptors that have nothing to do with one another give hardly a match") {
  const std::vector<IndexPair> matches =
      MatchDescriptors(RandomDescriptors(200, 1), RandomDescriptors(200, 2));
  CHECK(matches.size() <= 4);
}

TEST_CASE("one descriptor, or none, has no second nearest and gives no match") {
  const cv::Mat one = RandomDescriptors(1, 1);
  CHECK(MatchDescriptors(one, one).empty());
  CHECK(MatchDescriptors(cv::Mat(), one).empty());
}

}  // namespace
}  // namespace freelsd
