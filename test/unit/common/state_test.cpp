#include "ratslam/common/state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "unit/message_of.h"

namespace ratslam {
namespace {

struct Place {
  double x = 0.0;
  double y = 0.0;
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
  }
};

enum class Colour : std::uint16_t { kRed = 3, kBlue = 700 };

struct Entry {
  std::int64_t stamp = 0;
  Place place;
  Colour colour = Colour::kRed;
  std::optional<double> sigma;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::vector<std::uint8_t> bytes;
  bool flag = false;
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("place", place);
    fields("colour", colour);
    fields("sigma", sigma);
    fields("offset", offset);
    fields("bytes", bytes);
    fields("flag", flag);
  }
};

struct Whole {
  std::string name{"a name\0with a zero", 18};
  std::uint64_t large = std::numeric_limits<std::uint64_t>::max();
  double minus_zero = -0.0;
  float tiny = std::numeric_limits<float>::denorm_min();
  std::deque<Eigen::Matrix<double, 2, 3>> matrices{Eigen::Matrix<double, 2, 3>::Random()};
  Eigen::MatrixXd dynamic = Eigen::MatrixXd::Random(3, 5);
  std::optional<Place> nowhere;
  std::optional<Place> somewhere = Place{1.0, std::nextafter(2.0, 3.0)};
  std::vector<Entry> entries{{5, {1.0, -0.0}, Colour::kBlue, 0.25, {1, 2, 3}, {7, 8, 9}, true},
                             {-6, {std::nan(""), 3.0}, Colour::kRed, {}, {4, 5, 6}, {}, false}};
  std::vector<Entry> empty;
  Eigen::Isometry3d pose{Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())};
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("name", name);
    fields("large", large);
    fields("minus_zero", minus_zero);
    fields("tiny", tiny);
    fields("matrices", matrices);
    fields("dynamic", dynamic);
    fields("nowhere", nowhere);
    fields("somewhere", somewhere);
    fields("entries", entries);
    fields("empty", empty);
    fields("pose", pose);
  }
};

State stateOf(const Whole& whole) {
  State state;
  state.write(whole);
  return state;
}

TEST(State, GivesBackWhatItWasGiven) {
  const Whole whole;
  Whole other;
  other.name.clear();
  other.minus_zero = 1.0;
  other.nowhere = Place{};
  other.somewhere.reset();
  other.entries.clear();
  other.empty.resize(3);
  other.matrices.clear();
  other.dynamic.resize(0, 0);
  stateOf(whole).read(other);
  EXPECT_TRUE(stateOf(other) == stateOf(whole));
  EXPECT_TRUE(std::signbit(other.minus_zero));
  EXPECT_FALSE(other.nowhere);
  ASSERT_EQ(other.entries.size(), 2U);
  EXPECT_EQ(other.entries[0].bytes, whole.entries[0].bytes);
  EXPECT_TRUE(std::isnan(other.entries[1].place.x));
  EXPECT_FALSE(other.entries[1].sigma);
}

TEST(State, SurvivesAsBytes) {
  const State state = stateOf(Whole{});
  EXPECT_TRUE(State::fromBytes(state.toBytes()) == state);
}

TEST(State, RefusesBytesThatAreCutOrChanged) {
  const std::vector<std::uint8_t> bytes = stateOf(Whole{}).toBytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(State::fromBytes({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}),
                 std::runtime_error);
  }
  for (std::size_t bit = 0; bit < bytes.size() * 8; bit += 7) {
    std::vector<std::uint8_t> flipped = bytes;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
    try {
      Whole whole;
      State::fromBytes(flipped).read(whole);  // may pass where the bit is a value's, must never crash
    } catch (const std::runtime_error&) {
    }
  }
}

TEST(State, RefusesNamesThatNobodyCouldRead) {
  for (const std::string& name : {std::string(1, '\0'), std::string("two\nlines"), std::string()}) {
    State state;
    state.set(name, 1.0);
    try {
      State::fromBytes(state.toBytes());
      FAIL() << name;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("a name of " + std::to_string(name.size())),
                std::string::npos);
    }
  }
}

TEST(State, NamesWhatIsMissing) {
  const State state = stateOf(Whole{});
  EXPECT_NE(test::messageOf([&] { state.get<double>("speed"); }).find("speed: it is missing"),
            std::string::npos);
  EXPECT_NE(test::messageOf([&] { state.child("entries").get<double>("z"); }).find("entries/z"),
            std::string::npos);
}

TEST(State, NamesWhatHasAnotherTypeOrShape) {
  State state;
  state.set("speed", 1.0);
  state.set("place", Eigen::Vector3d(1, 2, 3));
  EXPECT_NE(test::messageOf([&] { state.get<float>("speed"); }).find("speed: it is float64[], not float32[]"),
            std::string::npos);
  EXPECT_NE(test::messageOf([&] { state.get<Eigen::Vector2d>("place"); }).find("place: it is float64[3 x 1]"),
            std::string::npos);
  EXPECT_NE(test::messageOf([&] { state.get<std::vector<double>>("speed"); }).find("speed"),
            std::string::npos);
}

TEST(State, MakesLaterWhatNobodyLooksAtYet) {
  int made = 0;
  State state;
  for (const int value : {1, 2}) {  // the second replaces the first
    state.setLater("later", [&made, value](State& inner) {
      ++made;
      inner.set("value", value);
      inner.child("deeper").set("value", 3);
    });
  }
  state.set("now", 4);
  State copy = state;
  const State moved = std::move(state);
  EXPECT_EQ(made, 0);
  EXPECT_TRUE(moved.hasChild("later"));
  EXPECT_EQ(moved.child("later").get<int>("value"), 2);
  EXPECT_EQ(moved.child("later").child("deeper").path(), "later/deeper");
  EXPECT_EQ(made, 1);
  EXPECT_EQ(moved.toBytes(), copy.toBytes());
  EXPECT_EQ(made, 2);
  State at_once;
  at_once.set("now", 4);
  at_once.child("later").set("value", 2);
  at_once.child("later").child("deeper").set("value", 3);
  EXPECT_EQ(at_once, moved);
  copy.setLater("later", [](State&) { throw std::runtime_error("it cannot be made"); });
  EXPECT_THROW(copy.toBytes(), std::runtime_error);
}

TEST(State, KeepsTheRowsOfATableAsTheyWereWhenItWasSet) {
  std::vector<Entry> rows(3);
  State state;
  state.set("rows", rows);
  const std::vector<std::uint8_t> before = [&rows] {
    State other;
    other.set("rows", rows);
    return other.toBytes();
  }();
  rows.clear();
  EXPECT_EQ(state.toBytes(), before);
}

/// As a damaged file may claim.
TEST(State, AShapeOfAnyLengthIsRefusedInOneLine) {
  StateArray array;
  array.type = StateType::kInt8;
  array.shape.assign(1000, 1);
  array.bytes.resize(2);
  State state;
  const std::string said = test::messageOf([&] { state.setArray("cells", array); });
  EXPECT_NE(said.find("2 bytes do not make int8[1 x 1"), std::string::npos) << said;
  EXPECT_NE(said.find("1000 sizes"), std::string::npos) << said;
  EXPECT_LT(said.size(), 200U);
}

TEST(State, RefusesAnotherVersion) {
  State state;
  state.child("part").setVersion(2);
  EXPECT_NO_THROW(std::as_const(state).child("part").requireVersion(2));
  EXPECT_NE(test::messageOf([&] { state.child("part").requireVersion(1); }).find("part/version: it is 2"),
            std::string::npos);
}

}  // namespace
}  // namespace ratslam
