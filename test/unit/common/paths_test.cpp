#include "ratslam/common/paths.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

TEST(Paths, ATildeAtTheBeginningIsTheHomeFolder) {
  const char* const home = std::getenv("HOME");
  const std::string before = home != nullptr ? home : "";
  setenv("HOME", "/home/somebody", 1);
  EXPECT_EQ(withHome("~/robot1"), "/home/somebody/robot1");
  EXPECT_EQ(withHome("~"), "/home/somebody");
  for (const char* const other : {"", "/a/~/b", "a~", "~other/b", "./~/b"}) EXPECT_EQ(withHome(other), other);
  if (home != nullptr) setenv("HOME", before.c_str(), 1);
}

TEST(Paths, OnePlaceHasManyNames) {
  const fs::path folder = fs::temp_directory_path() / ("paths_test." + std::to_string(getpid()));
  fs::create_directories(folder / "sub");
  std::ofstream(folder / "file") << "text";
  fs::create_symlink(folder / "file", folder / "link");
  EXPECT_TRUE(sameFile(folder / "file", folder / "sub" / ".." / "file"));
  EXPECT_TRUE(sameFile(folder / "file", folder / "link"));
  EXPECT_TRUE(sameFile(folder / "none", folder / "sub" / ".." / "none")) << "though neither is there";
  EXPECT_FALSE(sameFile(folder / "file", folder / "none"));
  EXPECT_FALSE(sameFile("", ""));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace ratslam
