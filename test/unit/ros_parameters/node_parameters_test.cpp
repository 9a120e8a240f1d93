#include "ratslam_ros/support/node_parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>

#include "ratslam/system/pipeline.h"
#include "unit/message_of.h"

namespace ratslam {
namespace {

TEST(TopicName, TakesEveryFormOfRootSeenInTheWild) {
  EXPECT_EQ(topicName("", "odom"), "odom");
  EXPECT_EQ(topicName("irat_red", "odom"), "irat_red/odom");
  EXPECT_EQ(topicName("stlucia", "camera/image"), "stlucia/camera/image");
  EXPECT_EQ(topicName("/newcollege/", "odom"), "/newcollege/odom");
}

TEST(TopicName, RefusesWhatIsNoName) {
  const std::string message = test::messageOf<std::exception>([] { topicName("new college", "odom"); });
  EXPECT_NE(message.find("topic_root: value 'new college'"), std::string::npos) << message;
}

TEST(XmlRpcParameters, KeepTypesAndSayWhereTheyComeFrom) {
  XmlRpc::XmlRpcValue dictionary;
  dictionary["pc_dim_xy"] = 31;
  dictionary["pc_cell_x_size"] = 0.1;
  dictionary["vt_panoramic"] = XmlRpc::XmlRpcValue(true);
  dictionary["topic_root"] = std::string("/newcollege/");
  dictionary["exp_initial_em_deg"] = 140;
  const ParameterMap map = parametersFromXmlRpc(dictionary, "/ratslam_pc");
  const auto pose_cells = readParams<PoseCellParams>(map);
  EXPECT_EQ(pose_cells.n_xy, 31);
  EXPECT_EQ(pose_cells.cell_size, 0.1);
  EXPECT_TRUE(readParams<LocalViewParams>(map).panoramic);
  EXPECT_EQ(readParams<NodeParams>(map).topic_root, "/newcollege/");
  EXPECT_EQ(readParams<ExperienceMapParams>(map).exp_initial_em_deg, 140.0);
  EXPECT_EQ(map.values().at("pc_dim_xy").origin, "/ratslam_pc/pc_dim_xy");
}

TEST(XmlRpcParameters, DoublesArriveToTheLastBit) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-300, 2e-5}) {
    XmlRpc::XmlRpcValue dictionary;
    dictionary["pc_global_inhib"] = value;
    const ParameterMap map = parametersFromXmlRpc(dictionary, "/pc");
    EXPECT_EQ(readParams<PoseCellParams>(map).global_inhibition, value);
  }
}

TEST(XmlRpcParameters, OpenRatSlamsSecondSpellingIsTheSameKey) {
  XmlRpc::XmlRpcValue dictionary;
  dictionary["template_x_size"] = 60;
  dictionary["vt_patch_normalisation"] = 3;
  const ParameterMap map = parametersFromXmlRpc(dictionary, "/lv");
  EXPECT_NO_THROW(map.rejectUnknown(systemKeys()));
  EXPECT_EQ(readParams<LocalViewParams>(map).view_template.patch_radius, 3);
}

TEST(XmlRpcParameters, GroupsAreRefusedByName) {
  XmlRpc::XmlRpcValue dictionary;
  dictionary["pose_cells"]["pc_dim_xy"] = 31;
  const std::string message =
      test::messageOf<std::exception>([&] { parametersFromXmlRpc(dictionary, "/ratslam_pc"); });
  EXPECT_NE(message.find("/ratslam_pc/pose_cells"), std::string::npos) << message;
}

TEST(XmlRpcParameters, WrongTypeNamesKeyValueAndOrigin) {
  XmlRpc::XmlRpcValue dictionary;
  dictionary["pc_dim_xy"] = std::string("many");
  const ParameterMap map = parametersFromXmlRpc(dictionary, "/ratslam_pc");
  const std::string message = test::messageOf<std::exception>([&] { readParams<PoseCellParams>(map); });
  for (const char* part : {"pc_dim_xy", "many", "/ratslam_pc/pc_dim_xy"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
}

struct BadValue {
  std::string key;
  std::string value;
  std::string allowed;
};

class BadNodeParams : public ::testing::TestWithParam<BadValue> {};

TEST_P(BadNodeParams, AreRefusedWithKeyValueAndWhatIsAllowed) {
  ParameterMap map;
  map.setFromAssignment(GetParam().key + "=" + GetParam().value);
  const std::string message = test::messageOf<std::exception>([&] { readParams<NodeParams>(map); });
  EXPECT_NE(message.find(GetParam().key), std::string::npos) << message;
  EXPECT_NE(message.find(GetParam().value), std::string::npos) << message;
  EXPECT_NE(message.find(GetParam().allowed), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(Keys, BadNodeParams,
                         ::testing::Values(BadValue{"image_transport", "theora", "compressed"},
                                           BadValue{"decision_source", "both", "action"},
                                           BadValue{"trajectory_format", "csv", "kitti"},
                                           BadValue{"sync_timeout", "0", "0.01"},
                                           BadValue{"image_queue_size", "-1", "[0"},
                                           BadValue{"odom_frame", "/odom", "slash"}),
                         [](const auto& test) { return test.param.key; });

INSTANTIATE_TEST_SUITE_P(
    FramesOfOneTree, BadNodeParams,
    ::testing::Values(BadValue{"map_frame", "base_link", "another frame than base_frame"},
                      BadValue{"base_frame", "map", "another frame than base_frame"},
                      BadValue{"odom_frame", "map", "another frame than odom_frame"},
                      BadValue{"odom_frame", "base_link", "another frame than odom_frame"}));

TEST(Frames, MayBeOneWhereNoneIsBroadcast) {
  ParameterMap map;
  map.setFromAssignment("map_frame=base_link");
  map.setFromAssignment("publish_tf=false");
  EXPECT_NO_THROW(readParams<NodeParams>(map));
}

TEST(UnknownKeys, AreNamedWithTheNearestKnownOne) {
  ParameterMap map;
  map.setFromAssignment("sync_timout=3");
  const std::string message = test::messageOf<std::exception>([&] { map.rejectUnknown(systemKeys()); });
  EXPECT_NE(message.find("sync_timout"), std::string::npos) << message;
  EXPECT_NE(message.find("did you mean sync_timeout"), std::string::npos) << message;
}

class ShippedConfigurations : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedConfigurations, ParseInEveryNode) {
  const std::string path = std::string(RATSLAM_SOURCE_DIR) + "/config/" + GetParam();
  const ParameterMap map = ParameterMap::fromFile(path);
  EXPECT_FALSE(map.values().empty());
  EXPECT_NO_THROW(map.rejectUnknown(systemKeys()));
  EXPECT_NO_THROW(PipelineParams::fromMap(map));
  EXPECT_NO_THROW(readParams<NodeParams>(map));
}

std::vector<std::string> shippedConfigurations() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(RATSLAM_SOURCE_DIR) + "/config")) {
    if (entry.is_regular_file()) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

INSTANTIATE_TEST_SUITE_P(Files, ShippedConfigurations, ::testing::ValuesIn(shippedConfigurations()));

struct Twin {
  std::string ini;
  std::string yaml;
  std::string topic_root;
};

class OpenRatSlamConfigurations : public ::testing::TestWithParam<Twin> {};

/// The YAML twin of an ini may say more, but never anything else. What an ini implies is apart: OpenRatSLAM
/// has one solver and one injection.
TEST_P(OpenRatSlamConfigurations, HaveAYamlTwinOfEqualValues) {
  const std::string folder = std::string(RATSLAM_SOURCE_DIR) + "/config/";
  const ParameterMap ini = ParameterMap::fromFile(folder + GetParam().ini);
  const ParameterMap yaml = ParameterMap::fromFile(folder + GetParam().yaml);
  EXPECT_EQ(readParams<NodeParams>(ini).topic_root, GetParam().topic_root);
  std::map<std::string, std::string> from_ini;
  const auto note = [&from_ini](const std::string& key, const auto& value, const Bounds&, const char*) {
    std::ostringstream text;
    if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::vector<double>>) text << value;
    from_ini[key] = text.str();
  };
  PipelineParams of_ini = PipelineParams::fromMap(ini);
  of_ini.visitFields(note);
  PipelineParams of_yaml = PipelineParams::fromMap(yaml);
  of_yaml.visitFields([&](const std::string& key, const auto& value, const Bounds&, const char*) {
    if (!ini.has(key) || key == "exp_solver" || key == "pc_openratslam_injection") return;
    std::ostringstream text;
    if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::vector<double>>) text << value;
    EXPECT_EQ(text.str(), from_ini[key]) << key;
  });
  EXPECT_EQ(of_ini.experience_map.exp_solver, "relaxation");
  EXPECT_TRUE(of_ini.pose_cells.openratslam_injection);
  EXPECT_FALSE(of_yaml.pose_cells.openratslam_injection);
}

INSTANTIATE_TEST_SUITE_P(
    Files, OpenRatSlamConfigurations,
    ::testing::Values(Twin{"config_irataus.txt", "irataus.yaml", "irat_red"},
                      Twin{"config_stlucia.txt", "stlucia.yaml", "stlucia"},
                      Twin{"config_oxford_newcollege.txt", "newcollege.yaml", "/newcollege/"}),
    [](const auto& test) { return test.param.yaml.substr(0, test.param.yaml.find('.')); });

}  // namespace
}  // namespace ratslam
