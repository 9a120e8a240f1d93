#include "ratslam/common/atomic_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("ratslam_atomic_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string contentOf(const std::string& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::size_t filesThere() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

TEST_F(AtomicFileTest, AppearsWholeWhenItIsCommitted) {
  AtomicFile file(path("a"));
  file.stream() << "one " << 0.1;
  EXPECT_FALSE(fs::exists(path("a")));
  file.commit();
  EXPECT_EQ(contentOf(path("a")), "one 0.10000000000000001");
  EXPECT_EQ(filesThere(), 1U);
}

TEST_F(AtomicFileTest, WithoutCommitTheFormerFileStays) {
  std::ofstream(path("a")) << "former";
  {
    AtomicFile file(path("a"));
    file.stream() << "new";
  }
  EXPECT_EQ(contentOf(path("a")), "former");
  EXPECT_EQ(filesThere(), 1U);
}

TEST_F(AtomicFileTest, AFullDiskIsSaidAndLeavesTheFormerFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  std::ofstream(path("a")) << "former";
  fs::create_symlink("/dev/full", path("a.part"));
  AtomicFile file(path("a"));
  file.stream() << std::string(100000, 'x');
  EXPECT_THROW(file.commit(), std::runtime_error);
  EXPECT_EQ(contentOf(path("a")), "former");
}

TEST_F(AtomicFileTest, WhatCannotBeWrittenIsSaidAtOnce) {
  EXPECT_THROW(AtomicFile(path("no/such/folder/a")), std::runtime_error);
  fs::create_directories(path("folder"));
  EXPECT_THROW(AtomicFile(path("folder")), std::runtime_error);
  EXPECT_THROW(requireWritable(path("folder")), std::runtime_error);
  requireWritable(path("fine"));
  EXPECT_FALSE(fs::exists(path("fine")));
  EXPECT_FALSE(fs::exists(path("fine.part")));
}

}  // namespace
}  // namespace ratslam
