#include "ratslam/experience_map/params.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "ratslam/experience_map/experience_map.h"
#include "unit/message_of.h"

namespace ratslam {
namespace {

/// What a map says about parameters, empty where it accepts them.
template <class Change>
std::string refusal(Change&& change) {
  ExperienceMapParams params;
  change(params);
  return test::messageOf<std::invalid_argument>([&] { ExperienceMap map(params); });
}

TEST(ExperienceMapParams, DefaultsAreOpenRatSlamsAndValid) {
  const ExperienceMapParams params;
  EXPECT_EQ(params.exp_correction, 0.5);
  EXPECT_EQ(params.exp_loops, 10);
  EXPECT_EQ(params.exp_initial_em_deg, 90.0);
  EXPECT_EQ(refusal([](ExperienceMapParams&) {}), "");
}

TEST(ExperienceMapParams, BadValuesAreNamed) {
  using Params = ExperienceMapParams;
  EXPECT_EQ(refusal([](Params& p) { p.exp_loops = -1; }),
            "exp_loops: value -1 is not allowed: it must lie within [0, 100000]");
  EXPECT_NE(refusal([](Params& p) { p.exp_correction = 0.75; }).find("exp_correction: value 0.75"),
            std::string::npos);
  EXPECT_NE(refusal([](Params& p) { p.exp_solver = "magic"; }).find("exp_solver: value magic"),
            std::string::npos);
  EXPECT_NE(refusal([](Params& p) {
              p.exp_recall_sigma = std::numeric_limits<double>::quiet_NaN();
            }).find("exp_recall_sigma: value nan"),
            std::string::npos);
  EXPECT_NE(refusal([](Params& p) { p.exp_goal_radius = -1.0; }).find("exp_goal_radius"), std::string::npos);
}

TEST(ExperienceMapParams, RelaxationCarriesNeitherScaleNorHeight) {
  using Params = ExperienceMapParams;
  EXPECT_NE(refusal([](Params& p) { p.exp_solver = "relaxation", p.exp_scale = true; }).find("exp_scale"),
            std::string::npos);
  EXPECT_NE(refusal([](Params& p) { p.exp_solver = "relaxation", p.exp_height = true; }).find("exp_height"),
            std::string::npos);
}

TEST(ExperienceMapParams, EveryFieldHasItsOwnKey) {
  ExperienceMapParams params;
  std::set<std::string> keys;
  int fields = 0;
  params.visitFields([&](const std::string& key, auto&, const Bounds&, const char* meaning) {
    keys.insert(key);
    ++fields;
    EXPECT_EQ(key.rfind("exp_", 0), 0U) << key;
    EXPECT_NE(std::string(meaning), "") << key;
  });
  EXPECT_EQ(keys.size(), static_cast<std::size_t>(fields));
}

}  // namespace
}  // namespace ratslam
