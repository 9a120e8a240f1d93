#include "ratslam_ros/support/part_commands.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include "ratslam/system/map_store.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;
using Request = PartCommands::Request;

/// A part that counts two things. It reads the second one last, as parts read the fields of their layout.
struct Part {
  int places = 0;
  int ways = 0;
  int begun = 0;

  PartActions actions() {
    PartActions actions;
    actions.save = [this](State& state) {
      state.set("places", places);
      state.set("ways", ways);
    };
    actions.load = [this](const State& state) {
      state.get("places", places);
      state.get("ways", ways);
    };
    actions.begin = [this] { ++begun; };
    actions.setLearning = [](bool) {};
    return actions;
  }
};

class PartCommandsTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / "part_commands_test";
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "map");
    startAnew();
    part_.places = 3;
    part_.ways = 4;
    checkpoints_->before(1, part_.actions().save);
  }
  void TearDown() override {
    commands_.reset();
    checkpoints_.reset();
    fs::remove_all(folder_);
  }

  void startAnew() {
    commands_.reset();
    checkpoints_.reset();
    part_ = {};
    NodeParams params;
    params.map_dir = folder_ / "map";
    checkpoints_.emplace(params, "local_view", std::map<std::string, std::string>());
    commands_.emplace(*checkpoints_, part_.actions());
    commands_->setEmpty();
  }

  /// How many places a node has that starts from the files as they are now.
  int placesAfterAKill() const {
    const fs::path copy = folder_ / "copy";
    fs::remove_all(copy);
    fs::copy(folder_ / "map", copy);
    NodeParams params;
    params.map_dir = copy;
    NodeCheckpoints checkpoints(params, "local_view", {});
    const std::optional<State> state = checkpoints.resume();
    return state ? state->get<int>("places") : -1;
  }

  std::string inMapDir(const std::string& name) const { return folder_ / "map" / name; }

  void run(std::uint32_t command, const std::string& path = "") {
    Request request;
    request.command = command;
    request.path = path;
    commands_->run(request);
  }

  /// A map of 30 places. @param whole  also of 40 ways; without them it is one of another layout
  std::string mapFile(bool whole) {
    MapCheckpoint map;
    State& state = map.state.child("local_view");
    state.set("places", 30);
    if (whole) state.set("ways", 40);
    const std::string path = inMapDir(whole ? "whole.db" : "other.db");
    MapWriter(path).save(map);
    return path;
  }

  void expectPart(int places, int ways, int begun) const {
    EXPECT_EQ(part_.places, places);
    EXPECT_EQ(part_.ways, ways);
    EXPECT_EQ(part_.begun, begun);
  }

  fs::path folder_;
  Part part_;
  std::optional<NodeCheckpoints> checkpoints_;
  std::optional<PartCommands> commands_;
};

TEST_F(PartCommandsTest, CheckChangesNothing) {
  run(Request::CHECK, mapFile(true));
  expectPart(3, 4, 0);
}

TEST_F(PartCommandsTest, CheckRefusesAMapThatCannotBeLoaded) {
  EXPECT_THROW(run(Request::CHECK, mapFile(false)), std::runtime_error);
  expectPart(3, 4, 0);
}

TEST_F(PartCommandsTest, CheckRefusesWhatCannotBeKept) {
  const std::string path = mapFile(true);
  fs::create_directories(inMapDir("local_view.trial.db") + "/in the way");  // also root cannot write there
  EXPECT_THROW(run(Request::CHECK, path), std::runtime_error);
  EXPECT_THROW(run(Request::CHECK), std::runtime_error);
  expectPart(3, 4, 0);
  fs::remove_all(inMapDir("local_view.trial.db"));
  run(Request::CHECK);
  expectPart(3, 4, 0);
}

TEST_F(PartCommandsTest, APathIsRelativeToMapDir) {
  mapFile(true);
  run(Request::CHECK, "whole.db");
  run(Request::LOAD, "whole.db");
  expectPart(30, 40, 1);
  EXPECT_EQ(placesAfterAKill(), 30);
}

TEST_F(PartCommandsTest, LoadTakesAWholeMap) {
  run(Request::LOAD, mapFile(true));
  expectPart(30, 40, 1);
}

TEST_F(PartCommandsTest, LoadOfAMapThatDoesNotFitLeavesThePartAsItIs) {
  EXPECT_THROW(run(Request::LOAD, mapFile(false)), std::runtime_error);
  expectPart(3, 4, 0);
}

TEST_F(PartCommandsTest, ResetForgetsWhatWasLearned) {
  run(Request::RESET);
  expectPart(0, 0, 1);
}

TEST_F(PartCommandsTest, WhatWasLoadedOrForgottenHoldsOverAKill) {
  run(Request::CHECKPOINT);  // the map before
  const std::string path = mapFile(true);
  run(Request::LOAD, path);
  EXPECT_EQ(placesAfterAKill(), 30);
  run(Request::RESET);
  EXPECT_EQ(placesAfterAKill(), 0);
}

TEST_F(PartCommandsTest, AMapThatWasLoadedBeforeTheFirstMessageCanBeSaved) {
  const std::string path = mapFile(true);
  startAnew();
  run(Request::LOAD, path);
  run(Request::CHECKPOINT);
  run(Request::SAVE, inMapDir("again.db"));
  EXPECT_TRUE(fs::exists(inMapDir("again.db")));
}

TEST_F(PartCommandsTest, FilesOutsideMapDirAreNeitherWrittenNorRead) {
  const std::string outside = folder_ / "outside.db";
  EXPECT_THROW(run(Request::SAVE, outside), std::runtime_error);
  EXPECT_FALSE(fs::exists(outside));
  fs::copy_file(mapFile(true), outside);
  for (const std::uint32_t command : {Request::CHECK, Request::LOAD}) {
    EXPECT_THROW(run(command, outside), std::runtime_error);
  }
  expectPart(3, 4, 0);
  run(Request::SAVE, inMapDir("inside.db"));
  EXPECT_TRUE(fs::exists(inMapDir("inside.db")));
}

}  // namespace
}  // namespace ratslam
