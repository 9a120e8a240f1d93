#include "ratslam/system/map_store.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "unit/message_of.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

struct Place {
  double x = 0.0;
  double y = 0.0;
  std::uint32_t id = 0;
  std::vector<std::uint8_t> bytes;
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
    fields("id", id);
    fields("bytes", bytes);
  }
};

/// A map of so many places, of which the first `moved` lie elsewhere.
MapCheckpoint checkpoint(std::size_t places, std::size_t moved = 0) {
  std::mt19937 random(3);
  std::vector<Place> rows;
  std::vector<double> path;
  for (std::size_t i = 0; i < places; ++i) {
    Place place;
    place.x = i == 0 ? -0.0 : static_cast<double>(random()) * 1e-3;
    place.y = i == 1 ? std::nan("") : 1.0 + (i < moved ? 0.5 : 0.0);
    place.id = 0xFFFFFFFFU - static_cast<std::uint32_t>(i);
    place.bytes.assign(i % 5, static_cast<std::uint8_t>(random()));
    rows.push_back(place);
    for (int k = 0; k < 20; ++k) path.push_back(static_cast<double>(random()));
  }
  MapCheckpoint map;
  map.stamp = static_cast<Stamp>(places) * 1'000'000'007;
  map.parameters = {{"pc_dim_xy", "30"}, {"vt_match_threshold", "0.040000000000000001"}};
  map.sessions = {{"0.1.0", 5, map.stamp}};
  map.state.child("experience_map").child("map").child("graph").set("experiences", rows);
  map.state.child("experience_map").set("path", path);
  map.state.child("odometry").set("elsewhere", rows);
  map.state.child("odometry").set("speed", -0.0F);
  return map;
}

bool equal(const MapCheckpoint& a, const MapCheckpoint& b) {
  return a.stamp == b.stamp && a.parameters == b.parameters && a.sessions == b.sessions &&
         a.state.toBytes() == b.state.toBytes();
}

std::vector<char> readBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void writeBytes(const std::string& path, const std::vector<char>& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

class MapStore : public testing::Test {
 protected:
  MapStore() : folder_(fs::temp_directory_path() / ("map_store_test." + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~MapStore() override { fs::remove_all(folder_); }
  std::string path(const std::string& name = "map.db") const { return (folder_ / name).string(); }
  void save(const MapCheckpoint& map) const { MapWriter(path()).save(map); }

  fs::path folder_;
};

TEST_F(MapStore, GivesBackWhatWasSaved) {
  for (const std::size_t places : {std::size_t{0}, std::size_t{1}, std::size_t{3000}}) {
    const MapCheckpoint map = checkpoint(places);
    save(map);
    EXPECT_TRUE(equal(loadMapFile(path()), map)) << places << " places";
  }
}

TEST_F(MapStore, FollowsAMapThatGrowsChangesAndShrinks) {
  MapWriter writer(path());
  for (const auto& [places, moved] : std::vector<std::pair<std::size_t, std::size_t>>{
           {10, 0}, {2000, 0}, {2000, 1000}, {1500, 3}, {0, 0}, {7, 7}}) {
    const MapCheckpoint map = checkpoint(places, moved);
    writer.save(map);
    EXPECT_TRUE(equal(loadMapFile(path()), map)) << places << " places, " << moved << " moved";
  }
  MapCheckpoint other;
  other.state.child("pose_cells").set("x", 1);
  writer.save(other);
  EXPECT_TRUE(equal(loadMapFile(path()), other));
}

TEST_F(MapStore, ReadsFromAFolderThatCannotBeWritten) {
  const MapCheckpoint map = checkpoint(20);
  save(map);
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_TRUE(equal(loadMapFile(path()), map));
  if (geteuid() != 0) {
    EXPECT_NE(test::messageOf([&] { MapWriter writer(path()); }).find("cannot write"), std::string::npos);
  }
  fs::permissions(folder_, fs::perms::owner_all);
}

TEST_F(MapStore, HasOneWriter) {
  {
    const MapLock first(path());
    EXPECT_NE(test::messageOf([&] { MapLock second(path()); }).find("another program writes to it"),
              std::string::npos);
    EXPECT_NE(test::messageOf([&] { MapLock third(path()); }).find("another program writes to it"),
              std::string::npos);
  }
  EXPECT_TRUE(fs::is_empty(folder_)) << "a lock that is let go leaves nothing behind";
  EXPECT_NO_THROW(MapLock again(path()));
}

TEST_F(MapStore, HasOneWriterOfBothCheckpointsOfAPart) {
  const std::string part = (folder_ / "experience_map").string();
  const MapLock node(part + ".a.db");
  EXPECT_NE(
      test::messageOf([&] { MapLock tool(part + ".b.db"); }).find(part + ".b.db: another program writes"),
      std::string::npos);
  EXPECT_NO_THROW(MapLock tool(part + ".db"));
}

TEST_F(MapStore, HasOneWriterAlsoWhileLocksComeAndGo) {
  std::atomic<int> holders{0};
  std::atomic<bool> alone{true};
  const auto work = [&] {
    for (int i = 0; i < 2000; ++i) {
      try {
        const MapLock lock(path());
        if (++holders > 1) alone = false;
        --holders;
      } catch (const std::runtime_error&) {  // the others have it
      }
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(alone);
}

TEST_F(MapStore, RefusesWhatIsNoMapFile) {
  EXPECT_NE(test::messageOf([&] { loadMapFile(path()); }).find("there is no such map file"),
            std::string::npos);
  EXPECT_NE(test::messageOf([&] { loadMapFile("/tmp"); }).find("it is a folder"), std::string::npos);
  writeBytes(path(), std::vector<char>(5000, 'x'));
  EXPECT_NE(test::messageOf([&] { loadMapFile(path()); }).find("it is not a map file"), std::string::npos);
  EXPECT_NE(test::messageOf([&] { MapWriter writer(path()); }).find("it is not a map file"),
            std::string::npos);
  writeBytes(path(), {});
  EXPECT_NE(test::messageOf([&] { loadMapFile(path()); }).find("it is not a map file"), std::string::npos);
}

TEST_F(MapStore, RefusesAnotherVersion) {
  save(checkpoint(3));
  std::vector<char> bytes = readBytes(path());
  bytes[63] = 9;  // PRAGMA user_version, big-endian at 60
  writeBytes(path(), bytes);
  EXPECT_NE(test::messageOf([&] { loadMapFile(path()); }).find("its version is 9"), std::string::npos);
  EXPECT_NE(test::messageOf([&] { MapWriter writer(path()); }).find("its version is 9"), std::string::npos);
}

TEST_F(MapStore, RefusesOtherParameters) {
  const MapCheckpoint map = checkpoint(3);
  auto parameters = map.parameters;
  EXPECT_NO_THROW(requireParameters("a.db", map, parameters));
  parameters["vt_match_threshold"] = "0.05";
  const std::string message = test::messageOf([&] { requireParameters("a.db", map, parameters); });
  EXPECT_EQ(message.rfind("a.db: made with vt_match_threshold = 0.04", 0), 0U) << message;
  EXPECT_NE(message.find("0.05"), std::string::npos);
}

TEST_F(MapStore, RefusesATruncatedFileWhereverItEnds) {
  save(checkpoint(300));
  const std::vector<char> bytes = readBytes(path());
  for (std::size_t i = 0; i < 200; ++i) {
    const std::size_t size = bytes.size() * i / 200;
    writeBytes(path("cut.db"), {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    const std::string message = test::messageOf([&] { loadMapFile(path("cut.db")); });
    EXPECT_EQ(message.rfind(path("cut.db") + ": ", 0), 0U) << size << " of " << bytes.size() << " bytes";
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

TEST_F(MapStore, NoticesEveryFlippedBitThatMatters) {
  const MapCheckpoint map = checkpoint(300);
  save(map);
  const std::vector<char> bytes = readBytes(path());
  std::mt19937 random(11);
  std::size_t refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<char> flipped = bytes;
    const std::size_t bit = random() % (bytes.size() * 8);
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    writeBytes(path("flipped.db"), flipped);
    try {
      EXPECT_TRUE(equal(loadMapFile(path("flipped.db")), map)) << "bit " << bit;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).rfind(path("flipped.db") + ": ", 0), 0U) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000U);
}

}  // namespace
}  // namespace ratslam
