#include "ratslam/odometry/registry.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "ratslam/odometry/orb/orb_source.h"
#include "ratslam/odometry/profile/profile_source.h"

namespace ratslam {

OdometryRegistry standardOdometry() {
  OdometryRegistry registry;
  registry.add<ProfileSource>("profile", "intensity profiles");
  registry.add<OrbSource>("orb", "ORB features; needs the camera's calibration");
  registry.addOutside("topic", "the bag's own", OdometryOrigin::kTopic);
  registry.addOutside("FILE",
                      "a CSV file with the columns frame,stamp,linear_x,angular_z, such as the odometry.csv "
                      "that a run leaves",
                      OdometryOrigin::kFile);
  return registry;
}

void OdometryRegistry::addOutside(const std::string& name, const std::string& meaning,
                                  OdometryOrigin origin) {
  OdometryKind kind;
  kind.name = name;
  kind.meaning = meaning;
  kind.origin = origin;
  insert(std::move(kind));
}

void OdometryRegistry::insert(OdometryKind kind) {
  for (const OdometryKind& there : kinds_) {
    if (there.name == kind.name) throwBadValue("odometry", kind.name, "there is one of this name already");
  }
  kinds_.push_back(std::move(kind));
}

const OdometryKind& OdometryRegistry::find(const std::string& name) const {
  const auto named = std::find_if(kinds_.begin(), kinds_.end(), [&name](const OdometryKind& kind) {
    return kind.origin != OdometryOrigin::kFile && kind.name == name;
  });
  if (named != kinds_.end()) return *named;
  const auto file = std::find_if(kinds_.begin(), kinds_.end(), [](const OdometryKind& kind) {
    return kind.origin == OdometryOrigin::kFile;
  });
  if (file != kinds_.end() && std::filesystem::exists(name)) return *file;
  std::string list;
  for (const OdometryKind& kind : kinds_) {
    if (kind.origin != OdometryOrigin::kFile) list += (list.empty() ? "" : ", ") + kind.name;
  }
  throwBadValue("odometry", "'" + name + "'", "it must be one of " + list + ", or a file that is there");
}

OdometryParams::OdometryParams(const OdometryRegistry& registry) {
  for (const OdometryKind& kind : registry.kinds()) {
    if (kind.params) all_.push_back({kind.name, *kind.params});
  }
}

void OdometryParams::validate() const {
  for (const Named& named : all_) named.params.validate();
}

std::unique_ptr<OdometrySource> OdometryParams::make(const OdometryKind& kind,
                                                     const std::optional<CameraModel>& camera) const {
  if (kind.needs_camera && !camera) {
    throwBadValue(
        "odometry", kind.name,
        "it needs a calibration: calib.txt, camera_info in the bag, --calibration FILE, or camera_fx "
        "... in the configuration");
  }
  const auto named =
      std::find_if(all_.begin(), all_.end(), [&kind](const Named& one) { return one.name == kind.name; });
  if (named == all_.end()) throw std::out_of_range("no parameters of the odometry " + kind.name);
  return kind.make(named->params, camera);
}

}  // namespace ratslam
