#include "sim/base/json_file.hpp"

#include <gtest/gtest.h>

#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

// A length, and a holder of one of two kinds.
double read_part(const Json& document, const std::string& file) {
  JsonFields f(document, file);
  const double length = f.number("length_um", rule::positive());
  JsonFields holder = f.object("holder");
  if (holder.choice("type", {"hand", "gripper"}) == 0)
    holder.number("stiffness_N_m", rule::positive());
  else
    holder.number("force_uN", rule::positive());
  holder.finish();
  for (std::size_t i = 0; f.present("list") && i < f.raw("list").size(); ++i) {
    JsonFields entry = f.object("list", i);
    entry.number("length_um", rule::positive());
    entry.finish();
  }
  f.finish();
  return length;
}

class JsonFile : public ::testing::Test {
 protected:
  // What is refused in a file, without its name.
  std::string refusal(const std::string& text) const {
    const std::string file = folder_ / "part.json";
    write_text(file, text);
    try {
      read_json(file, [&](const Json& document) { return read_part(document, file); });
    } catch (const BadInput& error) {
      const std::string said = error.what();
      EXPECT_EQ(said.find(file + ": "), 0u) << said;
      return said.substr(file.size() + 2);
    }
    return "";
  }

 private:
  testing::TemporaryFolder folder_;
};

TEST_F(JsonFile, IsReadWhole) {
  EXPECT_EQ(refusal(R"({"length_um": 2, "holder": {"type": "hand", "stiffness_N_m": 1},
                        "list": [{"length_um": 3}]})"),
            "");
}

TEST_F(JsonFile, AKeyIsRefusedWithItsLine) {
  EXPECT_EQ(refusal("{\n\"length_um\":\n\n-2}"), "line 2: length_um = -2: must be positive");
  // The same name further up is another key.
  EXPECT_EQ(
      refusal("{\n\"length_um\": 2,\n\"holder\": {\n\"type\": \"hand\",\n\"stiffness_N_m\": 1,"
              "\n\"length_um\": 3}}"),
      "line 6: holder.length_um = 3: unknown key; known here: stiffness_N_m type");
  EXPECT_EQ(refusal("[1,\n2]"), "the document = [1,2]: must be an object {...}");
}

TEST_F(JsonFile, AnUnknownKeyGoesBeforeAMissingOne) {
  EXPECT_EQ(
      refusal("{\n\"holder\": {\"type\": \"hand\", \"stiffness_N_m\": 1},\n\"lenght_um\": 2}"),
      "line 3: lenght_um = 2: unknown key; did you mean length_um?");
  EXPECT_EQ(refusal("{\n\"length_mm\": 2}"),
            "line 2: length_mm = 2: unknown key; here it is length_um = 2000");
  EXPECT_EQ(refusal("{\n\"length_um\": 2,\n\"holdr\": {\"type\": \"hand\"}}"),
            "line 3: holdr = {\"type\":\"hand\"}: unknown key; did you mean holder?");
  // Of whichever type the holder is: that alone which none of them has.
  for (const char* own : {"force_uN", "stiffness_N_m"})
    for (const char* misspelt : {"Type", "typ"})
      EXPECT_EQ(refusal(std::string("{\"length_um\": 2, \"holder\": {\n\"") + misspelt +
                        "\": \"hand\",\n\"" + own + "\": 1}}"),
                std::string("line 2: holder.") + misspelt +
                    " = \"hand\": unknown key; did you mean holder.type?");
}

TEST_F(JsonFile, AMissingKeyIsNamedWhereAllOthersMayBeRight) {
  EXPECT_EQ(refusal("{\"holder\": {\"type\": \"hand\"}}"),
            "length_um is missing: a number that must be positive");
  // Of a gripper, which it might be.
  EXPECT_EQ(refusal("{\"length_um\": 2, \"holder\": {\"force_uN\": 1}}"),
            "holder.type is missing: must be one of \"hand\" \"gripper\"");
}

TEST_F(JsonFile, AnEntryOfAListIsNamedWithoutTheLineOfAnotherKey) {
  const std::string whole =
      "{\"length_um\": 2, \"holder\": {\"type\": \"hand\", "
      "\"stiffness_N_m\": 1},\n\"list\": [{\"length_um\": 1}, {";
  EXPECT_EQ(refusal(whole + "\"length_um\": -1}]}"), "list[1].length_um = -1: must be positive");
  EXPECT_EQ(refusal(whole + "}]}"), "list[1].length_um is missing: a number that must be positive");
}

TEST_F(JsonFile, ACommentIsCalledOne) {
  EXPECT_EQ(refusal("{\n// how long\n\"length_um\": 2}"), "line 2: JSON has no comments");
  EXPECT_EQ(refusal("{\n\"length_um\": 2 /* long */\n}"), "line 2: JSON has no comments");
  EXPECT_EQ(refusal("{\n\"length_um\": 2\n}\n# long\n"), "line 4: JSON has no comments");
  EXPECT_EQ(refusal("{\n\"length_um\": 2 / 3}").find("not valid JSON: parse error at line 2"), 0u);
}

// A controller has its weights in another file.
TEST_F(JsonFile, WhatIsRefusedElsewhereIsNotLookedForHere) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "controller.json";
  write_text(file, "{\"weight\": 1}");
  const Json weights = Json::object();
  try {
    read_json(file, [&](const Json&) {
      JsonFields f(weights, "weights");
      return f.number("weight", rule::any());
    });
    ADD_FAILURE();
  } catch (const BadInput& error) {
    EXPECT_STREQ(error.what(), "weights: weight is missing: a number that must be a finite number");
  }
}

}  // namespace
}  // namespace ferrule
