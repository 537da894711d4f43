#include "api/import/poses/yaml.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

std::string Repeated(const std::string& text, int count) {
  std::string repeated;
  for (int i = 0; i < count; ++i) repeated += text;
  return repeated;
}

// What it is refused with; "nothing" where it is read.
std::string Refusal(const std::string& text) {
  try {
    ParseYaml(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing";
}

TEST_CASE("yaml: maps, lists below and beside their key, brackets over lines, remarks, quotes") {
  const nlohmann::json yaml = ParseYaml(
      "%YAML:1.0\n---\na:\n  b: [1, 2.5,\n      -3e-1] # end\n  'c': x\nd:\n- [1, 2]\n- [3]\ne: "
      "\"# no: remark\"\nf: !!opencv-matrix\n  rows: 1\ng:\n");
  CHECK(yaml["a"]["b"] == nlohmann::json({1.0, 2.5, -0.3}));
  CHECK(yaml["d"] == nlohmann::json::parse("[[1.0, 2.0], [3.0]]"));
  CHECK(yaml["e"] == "# no: remark");
  CHECK(yaml["f"]["rows"] == 1.0);
  CHECK(yaml["g"].is_null());
}

TEST_CASE("yaml: bombs and nonsense are refused") {
  CHECK_THROWS(ParseYaml("a: &x 1\nb: *x"));
  CHECK_THROWS(ParseYaml("a: [1, 2"));
  CHECK_THROWS(ParseYaml("a: 1\na: 2"));
  CHECK_THROWS(ParseYaml("no key"));
  CHECK_THROWS(ParseYaml("a: " + std::string(100, '[') + std::string(100, ']')));
  CHECK_THROWS(ParseYaml(std::string(70000, 'a')));
  CHECK_NOTHROW(ParseYaml(""));
}

TEST_CASE("yaml: text stays text where it is quoted, null has three forms") {
  const nlohmann::json yaml = ParseYaml("a: '1'\nb: 1\nc: ~\nd: null\ne:\nf: 1e999\n\"g h\": x");
  CHECK(yaml["a"] == "1");
  CHECK(yaml["b"] == 1.0);
  CHECK(yaml["c"].is_null());
  CHECK(yaml["d"].is_null());
  CHECK(yaml["e"].is_null());
  CHECK(yaml["f"] == "1e999");
  CHECK(yaml["g h"] == "x");
  CHECK(ParseYaml("a: {b: [1, 2], c: x}\r\nd: 2\r\n")["a"]["b"][1] == 2.0);
  CHECK(ParseYaml("# nothing\n").is_null());
}

TEST_CASE("yaml: refusals name the line and the limit") {
  CHECK(Refusal("a: 1\nb: " + Repeated("[", 100) + Repeated("]", 100)) ==
        "line 2: nested deeper than 16");
  CHECK(Refusal(Repeated("[", 20000)) == "line 1: nested deeper than 16");
  CHECK(Refusal(Repeated("{a: ", 10000)) == "line 1: nested deeper than 16");
  CHECK(Refusal(Repeated("- ", 30000)) == "line 1: nested deeper than 16");
  CHECK(Refusal(Repeated("? ", 30000)) == "line 1: nested deeper than 16");
  std::string steps;
  for (int i = 0; i < 200; ++i) steps += std::string(static_cast<size_t>(i), ' ') + "a:\n";
  CHECK(Refusal(steps) == "line 17: nested deeper than 16");
  CHECK(Refusal(std::string(70000, 'a')) == "more than 64 KiB");
  CHECK(Refusal("a: 1\nb: 2\na: 3") == "line 3: the key \"a\" comes twice");
  CHECK(Refusal("a: 1\nb: &x [1]\nc: [*x, *x]") == "line 2: anchors and aliases are not read");
  CHECK(Refusal("<<: *x").starts_with("line 1: "));
  CHECK(Refusal("[1, 2]: 3") == "line 1: a key must be a word");
}

}  // namespace
}  // namespace freelsd
