#include "tests/api/import/poses/side_files.h"

namespace freelsd {
namespace {

constexpr char kPoses[] = "image,lat,lon,alt\na.jpg,47,8,500\n";
constexpr char kByteOrderMark[] = "\xEF\xBB\xBF";

TEST_CASE("side files: an empty one is told of by name, and the others are read") {
  const PoseFile file = PosesFromFiles({{"notes/markers.csv", ""},
                                        {"poses.csv", kPoses},
                                        {"meta.json", " \r\n"},
                                        {"marked.csv", kByteOrderMark}},
                                       {});
  CHECK(file.poses.size() == 1);
  CHECK(file.formats.size() == 1);
  REQUIRE(file.warnings.size() == 3);
  CHECK(file.warnings[0] == "notes/markers.csv: the file is empty, ignored");
  CHECK(file.warnings[1] == "meta.json: the file is empty, ignored");
  CHECK(file.warnings[2] == "marked.csv: the file is empty, ignored");
}

TEST_CASE("side files: an empty one is enough where photographs are there, and alone it is not") {
  SideContext context;
  context.image_tags.emplace_back("a.jpg", FrameMeta{});
  CHECK(Warns(PosesFromFiles({{"poses.csv", ""}}, context), "poses.csv: the file is empty"));
  CHECK(ErrorOfFiles({{"poses.csv", ""}}) == "422 InvalidPoses /poses/poses.csv");
  CHECK(ErrorOfFiles({{"poses.csv", kByteOrderMark}, {"b.json", "\n"}}) ==
        "422 InvalidPoses /poses/poses.csv");
}

}  // namespace
}  // namespace freelsd
