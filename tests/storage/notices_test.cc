#include "storage/notices.h"

#include <doctest/doctest.h>

#include "tests/storage/small_disk.h"
#include "tests/storage/temporary_folder.h"

namespace freelsd {
namespace {

TEST_CASE("notices: they survive a restart, and stay listed once they are acknowledged") {
  const TemporaryFolder folder;
  std::vector<std::string> logged;
  const auto log = [&logged](const std::string& text) { logged.push_back(text); };
  {
    NoticeBoard notices(folder.path() / "notices", log);
    notices.Add("first\n\xff");
    notices.AddForNow("of this process");
    notices.Add("second");
    REQUIRE(notices.List().size() == 3);
    CHECK(notices.Acknowledge(notices.List()[0].id));
    CHECK_FALSE(notices.Acknowledge("1"));
    CHECK_FALSE(notices.Acknowledge("../../freelsd.db"));
  }
  CHECK(logged.size() == 3);
  NoticeBoard notices(folder.path() / "notices", log);
  CHECK(logged.size() == 3);
  REQUIRE(notices.List().size() == 2);
  CHECK(notices.List()[0].text == "first ?");
  CHECK(notices.List()[0].acknowledged_at_us);
  CHECK(notices.List()[1].text == "second");
  CHECK_FALSE(notices.List()[1].acknowledged_at_us);
  CHECK(notices.List()[1].raised_at_us > notices.List()[0].raised_at_us);
}

TEST_CASE("notices: on a full disk they are stored and acknowledged all the same") {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "1m");
  if (!IsMounted(disk)) return;
  std::string id;
  {
    NoticeBoard notices(folder.path() / "disk/notices", {});
    disk.Fill(0);
    notices.Add("the copy is lost");
    id = notices.List()[0].id;
  }
  {
    NoticeBoard notices(folder.path() / "disk/notices", {});
    REQUIRE(notices.List().size() == 1);
    CHECK(notices.List()[0].text == "the copy is lost");
    CHECK(notices.Acknowledge(id));
  }
  CHECK(NoticeBoard(folder.path() / "disk/notices", {}).List()[0].acknowledged_at_us);
}

}  // namespace
}  // namespace freelsd
