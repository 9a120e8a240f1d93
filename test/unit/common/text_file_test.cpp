#include "ratslam/common/text_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

class TextFileTest : public ::testing::Test {
 protected:
  TextFileTest()
      : folder_(
            fs::temp_directory_path() /
            (std::string("text_file_") + ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~TextFileTest() override { fs::remove_all(folder_); }

  std::string file(const std::string& content) const {
    const std::string path = (folder_ / "file.txt").string();
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  static std::string complaint(const std::string& path) {
    try {
      readLines(path);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(TextFileTest, MarksBlanksAndEndsOfLinesAreNoPartOfTheText) {
  for (const char* content : {"a b\n\n c",
                              "\xEF\xBB\xBF"
                              "a b\r\n\r\nc\r\n",
                              "a b \r\rc\r", " a b\t\n \nc \n\n"}) {
    const auto lines = readLines(file(content));
    ASSERT_EQ(lines.size(), 2U) << content;
    EXPECT_EQ(lines[0].text, "a b");
    EXPECT_EQ(lines[1].text, "c");
    EXPECT_EQ(lines[1].number, 3);
  }
  EXPECT_TRUE(readLines(file("")).empty());
  EXPECT_EQ(readLines(file("Gr\xF6\xDF"
                           "e"))
                .size(),
            1U)
      << "bytes of another encoding are somebody's text";
}

TEST_F(TextFileTest, WhatIsNoTextIsNamed) {
  const std::string pipe = (folder_ / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(complaint(pipe).find("pipe: cannot open this file: it is no regular file"), std::string::npos);
  EXPECT_NE(complaint(folder_.string()).find("it is a folder"), std::string::npos);
  EXPECT_NE(complaint(folder_.string() + "/nowhere").find("no such file"), std::string::npos);
  EXPECT_NE(complaint(file(std::string("\xFF\xFE"
                                       "a\0b\0",
                                       6)))
                .find("UTF-16"),
            std::string::npos);
  EXPECT_NE(complaint(file(std::string("a\0b", 3))).find("no text"), std::string::npos);
}

TEST_F(TextFileTest, WhatIsLargeOrCannotBeReadIsRefusedInsteadOfTakenForEmpty) {
  const std::string large = file("a: 1\n");
  fs::resize_file(large, std::uintmax_t{1} << 36);  // a hole, which reads as zeros
  EXPECT_NE(complaint(large).find("no text"), std::string::npos);
  if (fs::exists("/proc/self/mem")) {  // a regular file that gives nothing but an error
    EXPECT_NE(complaint("/proc/self/mem").find("cannot be read to its end"), std::string::npos);
  }
}

TEST_F(TextFileTest, MessagesShowOneShortLine) {
  EXPECT_EQ(shown("  a\x07"
                  "b\n "),
            "a?b");
  EXPECT_EQ(shown(std::string(100, 'x')), std::string(60, 'x') + "...");
}

}  // namespace
}  // namespace ratslam
