#include "ratslam/common/parameter_map.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "unit/message_of.h"

namespace ratslam {
namespace {

struct Params {
  int count = 3;
  double size = 1.5;
  bool on = false;
  std::string name = "none";
  std::vector<double> values;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("count", count, Bounds{1, 10}, "");
    visit("size", size, Bounds{0, 2}, "");
    visit("on", on, Bounds{}, "");
    visit("name", name, Bounds{}, "");
    visit("values", values, Bounds{}, "");
  }
  void validate() const { checkBounds(*this); }
};

class ParameterMapTest : public ::testing::Test {
 protected:
  ParameterMapTest()
      : folder_(std::filesystem::temp_directory_path() /
                ("parameter_map_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) + "_" +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder_);
  }
  ~ParameterMapTest() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name, const std::string& content) {
    const auto path = folder_ / name;
    std::ofstream(path) << content;
    return path.string();
  }
  /// What reading these values says.
  static std::string complaint(const ParameterMap& map) {
    try {
      Params params;
      map.read(params);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

TEST_F(ParameterMapTest, ReadsYamlAndKeepsDefaultsOfAbsentKeys) {
  const auto map =
      ParameterMap::fromYaml(file("a.yaml", "count: 7\non: true\nvalues: [1, 2.5]\nname: town\n"));
  Params params;
  map.read(params);
  EXPECT_EQ(params.count, 7);
  EXPECT_TRUE(params.on);
  EXPECT_EQ(params.name, "town");
  EXPECT_EQ(params.values, (std::vector<double>{1.0, 2.5}));
  EXPECT_DOUBLE_EQ(params.size, 1.5);
}

TEST_F(ParameterMapTest, ReadsOpenRatSlamIniAndReportsTheDrawSection) {
  const std::string path = file("config.txt",
                                "[general]\ntopic_root=/newcollege/\n[ratslam]\ncount=4\n"
                                "vt_patch_normalisation=2\n[draw]\nenable=1\n[visual_odometry]\nsize=0.5\n");
  std::vector<std::string> remarks;
  const auto map = ParameterMap::fromFile(path, &remarks);
  ASSERT_FALSE(remarks.empty());
  EXPECT_NE(remarks.front().find("section [draw] is ignored"), std::string::npos) << remarks.front();
  EXPECT_EQ(map.values().at("topic_root").text, "/newcollege/");
  EXPECT_TRUE(map.has("vt_patch_normalise")) << "both spellings mean the same";
  Params params;
  map.read(params);
  EXPECT_EQ(params.count, 4);
  EXPECT_DOUBLE_EQ(params.size, 0.5);
}

TEST_F(ParameterMapTest, AnIniMeansOpenRatSlamsArithmeticUnlessItSaysOtherwise) {
  std::vector<std::string> remarks;
  const auto silent = ParameterMap::fromFile(file("silent.txt", "[ratslam]\ncount=4\n"), &remarks);
  EXPECT_EQ(silent.values().at("exp_solver").text, "relaxation");
  EXPECT_EQ(silent.values().at("pc_openratslam_injection").text, "true");
  ASSERT_EQ(remarks.size(), 2U);
  EXPECT_NE(remarks[0].find("exp_solver=relaxation"), std::string::npos) << remarks[0];
  EXPECT_NE(remarks[1].find("pc_openratslam_injection=true"), std::string::npos) << remarks[1];

  remarks.clear();
  const auto outspoken = ParameterMap::fromFile(
      file("said.txt", "[ratslam]\nexp_solver=graph\npc_openratslam_injection=false\n"), &remarks);
  EXPECT_EQ(outspoken.values().at("exp_solver").text, "graph");
  EXPECT_EQ(outspoken.values().at("pc_openratslam_injection").text, "false");
  EXPECT_TRUE(remarks.empty());
  EXPECT_FALSE(ParameterMap::fromFile(file("own.yaml", "count: 4\n")).has("exp_solver"));
}

TEST_F(ParameterMapTest, TheFirstLineTellsTheFormWhateverTheFileIsCalled) {
  const std::string ini = "# ours\n\n[ratslam]\ncount = 4   # a few\n";
  for (const char* name : {"a.txt", "a.txt.in", "a.cfg", "a.yaml", "a"}) {
    EXPECT_EQ(ParameterMap::fromFile(file(name, ini)).values().at("count").text, "4") << name;
    EXPECT_EQ(ParameterMap::fromFile(file(name, "\xEF\xBB\xBF" + ini)).values().at("count").text, "4")
        << name;
    EXPECT_EQ(ParameterMap::fromFile(file(name, "# ours\r\ncount: 5  # a few\r\n")).values().at("count").text,
              "5");
  }
}

TEST_F(ParameterMapTest, WhatRosparamTakesForABooleanIsOne) {
  for (const char* word : {"true", "True", "TRUE", "yes", "Yes", "on", "1"}) {
    Params params;
    ParameterMap::fromYaml(file("a.yaml", std::string("on: ") + word + "\n")).read(params);
    EXPECT_TRUE(params.on) << word;
  }
  for (const char* word : {"false", "False", "FALSE", "no", "No", "off", "0"}) {
    Params params;
    params.on = true;
    ParameterMap::fromYaml(file("a.yaml", std::string("on: ") + word + "\n")).read(params);
    EXPECT_FALSE(params.on) << word;
  }
}

TEST_F(ParameterMapTest, AKeyThatIsGivenTwiceIsNamed) {
  try {
    ParameterMap::fromYaml(file("a.yaml", "count: 5\nsize: 1\ncount: 6\n"));
    FAIL() << "the second value passed";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("a.yaml:3: count is given twice"), std::string::npos)
        << error.what();
  }
}

TEST_F(ParameterMapTest, ASecondDocumentIsNotPassedOver) {
  try {
    ParameterMap::fromYaml(file("a.yaml", "count: 1\n---\ncount: 2\n"));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("a.yaml:2: a second document"), std::string::npos)
        << error.what();
  }
}

TEST_F(ParameterMapTest, WhatIsNoValueIsSaid) {
  const auto yaml = [&](const std::string& text) {
    return test::messageOf([&] { ParameterMap::fromYaml(file("a.yaml", text)); });
  };
  EXPECT_NE(yaml("size: 1\ncount:\n").find("a.yaml:2: count: it has no value"), std::string::npos);
  // As rosparam has a node's parameters, and ROS 2 a node's.
  EXPECT_NE(
      yaml("ratslam:\n  count: 5\n").find("ratslam: it holds keys of its own; all keys stand at the margin"),
      std::string::npos);
  EXPECT_NE(test::messageOf([&] { ParameterMap::fromIni(file("a.txt", "count=5\n[ratslam]\nsize=1\n")); })
                .find("a.txt: count stands before any section; it belongs into [general], [ratslam] or "
                      "[visual_odometry]"),
            std::string::npos);
}

// rosparam reads 010 as 8, other readers as 10: nodes and runner would take different numbers.
TEST_F(ParameterMapTest, NumbersThatMayBeOctalAreRefused) {
  for (const char* text : {"size: 1\ncount: 010\n", "\ncount: -07\n", "\nvalues: [1, 00]\n"}) {
    const std::string said = test::messageOf([&] { ParameterMap::fromYaml(file("a.yaml", text)); });
    EXPECT_NE(said.find("a.yaml:2: "), std::string::npos) << said;
    EXPECT_NE(said.find("octal for rosparam"), std::string::npos) << said;
  }
  Params params;
  ParameterMap::fromYaml(file("a.yaml", "count: 0x08\nsize: 0\nname: \"007\"\nvalues: [0, 0.5, 00.5]\n"))
      .read(params);
  EXPECT_EQ(params.count, 8);
  EXPECT_EQ(params.name, "007");
}

TEST_F(ParameterMapTest, WhatIsNoLineOfYamlIsSaidToNeedABlank) {
  for (const char* text : {"count:3\nsize: 1\n", "on: true\ncount = 3\nsize: 1\n"}) {
    const std::string said = test::messageOf([&] { ParameterMap::fromYaml(file("a.yaml", text)); });
    EXPECT_NE(said.find("with a blank behind the colon"), std::string::npos) << text << said;
  }
}

TEST_F(ParameterMapTest, AListOfListsIsNamed) {
  EXPECT_NE(test::messageOf([&] {
              ParameterMap::fromYaml(file("a.yaml", "size: 1\nvalues: [[1], 2]\n"));
            }).find("a.yaml:2: values: its list holds more than single values"),
            std::string::npos);
}

TEST_F(ParameterMapTest, SectionsOfAnIniDoNotContradictEachOther) {
  const std::string text = "[ratslam]\nvt_patch_normalise=1\n[visual_odometry]\nvt_patch_normalisation=2\n";
  EXPECT_NE(test::messageOf([&] {
              ParameterMap::fromIni(file("a.txt", text));
            }).find("a.txt [visual_odometry]: vt_patch_normalisation is given twice"),
            std::string::npos);
}

TEST_F(ParameterMapTest, BlanksRoundAnAssignmentDoNotCount) {
  ParameterMap map;
  map.setFromAssignment(" count = 4 ");
  Params params;
  map.read(params);
  EXPECT_EQ(params.count, 4);
}

TEST_F(ParameterMapTest, AListMayBeAssignedAsYamlWritesIt) {
  for (const std::string text : {"values=[0.5, -2]", "values = [0.5,-2]", "values=[ 0.5 , -2 ]"}) {
    ParameterMap map;
    map.setFromAssignment(text);
    Params params;
    map.read(params);
    EXPECT_EQ(params.values, (std::vector<double>{0.5, -2.0})) << text;
  }
  ParameterMap none;
  none.setFromAssignment("values=[]");
  Params params;
  params.values = {1.0};
  none.read(params);
  EXPECT_TRUE(params.values.empty());
}

TEST_F(ParameterMapTest, WhatYamlWouldReadWithoutEndIsNamedByItsLine) {
  const std::string deep(100'000, '[');
  for (const std::string& bad :
       {std::string(",\n"), std::string(",[general]\nsize=30\n"), "a: " + deep, deep}) {
    try {
      ParameterMap::fromYaml(file("a.yaml", bad));
      FAIL() << bad.substr(0, 40);
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("a.yaml:1: "), std::string::npos) << error.what();
    }
  }
}

TEST_F(ParameterMapTest, WrongTypesAreNamed) {
  for (const std::string bad :
       {"count=three", "count=1.5", "size=big", "on=perhaps", "size=", "values=1", "values=[1, 2",
        "values=[1, two]", "values=[1,]", "values=[,]", "values=1, 2]", "values=["}) {
    ParameterMap map;
    map.setFromAssignment(bad);
    const std::string said = complaint(map);
    EXPECT_NE(said.find(bad.substr(0, bad.find('='))), std::string::npos) << bad << ": " << said;
    EXPECT_NE(said.find("is not"), std::string::npos) << bad << ": " << said;
  }
}

TEST_F(ParameterMapTest, ValuesOutOfRangeNameKeyValueAndBound) {
  ParameterMap map;
  map.setFromAssignment("count=11");
  const std::string said = complaint(map);
  EXPECT_NE(said.find("count: value 11"), std::string::npos) << said;
  EXPECT_NE(said.find("[1, 10]"), std::string::npos) << said;
  ParameterMap nan;
  nan.setFromAssignment("size=nan");
  EXPECT_NE(complaint(nan).find("size"), std::string::npos);
}

TEST_F(ParameterMapTest, MisspeltKeysAreRejectedWithASuggestion) {
  ParameterMap map;
  map.setFromAssignment("cuont=2");
  try {
    map.rejectUnknown(keysOf<Params>());
    FAIL() << "a misspelt key passed";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean count?"), std::string::npos) << error.what();
  }
}

TEST_F(ParameterMapTest, NamesAsLongAsAFileAreRefusedInAShortLineAndAtOnce) {
  const std::string name(8'000'000, 'k');
  const auto said = [](const auto& action) -> std::string {
    try {
      action();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "nothing";
  };
  ParameterMap map;
  map.setFromAssignment(name + "=2");
  std::set<std::string> known;
  for (int i = 0; i < 200; ++i) known.insert("vt_some_parameter_" + std::to_string(i));
  EXPECT_NE(said([&] { map.rejectUnknown(known); }).find("no parameter has this name"), std::string::npos);
  for (const std::string& path :
       {file("section.txt", "[" + name + "]\na=1\n"),
        file("twice.yaml", name + "\x01: 1\n" + name + "\x01: 2\n"), file("escape.yaml", "a: \"\\\x01\"\n"),
        file("key.txt", "[ratslam]\n" + name + " = 1\n" + name + " = 1\n")}) {
    const std::string line = said([&] { ParameterMap::fromFile(path).rejectUnknown(known); });
    EXPECT_LT(line.size(), path.size() + 200) << path;
    EXPECT_EQ(line.find('\x01'), std::string::npos) << path;
  }
}

TEST_F(ParameterMapTest, ANumberEndsWhereItsTextDoes) {
  ParameterMap map = ParameterMap::fromYaml(file("zero.yaml", "size: \"1\\0 and more\"\n"));
  EXPECT_NE(complaint(map).find("size: value '1? and more' is not a number"), std::string::npos)
      << complaint(map);
}

TEST_F(ParameterMapTest, UnreadableFilesAreNamed) {
  const std::string missing = (folder_ / "missing.yaml").string();
  for (const std::string& path :
       {missing, file("broken.yaml", "count: [1,\n"), file("nested.yaml", "count: {a: 1}\n"),
        file("words.yaml", "just words\n"), file("section.txt", "[what]\na=1\n"),
        file("noequals.txt", "[ratslam]\nword\n")}) {
    try {
      ParameterMap::fromFile(path);
      ADD_FAILURE() << path << " was accepted";
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace ratslam
