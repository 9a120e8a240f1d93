/// Registry of the odometries by name. Command lines, configurations and help texts are derived from it.
///
/// To add one: write a class that is an OdometrySource (source.h) and has
///
///     using Params = ...;                                    // a parameter struct (common/params.h)
///     MySource(const Params&);                               // or, if it needs the camera's calibration,
///     MySource(const CameraModel&, const Params&);
///
/// and add one line to standardOdometry() in registry.cpp:
///
///     registry.add<MySource>("mine", "what it is");
///
/// Its parameters are then read, checked, listed and written like those of the other odometries.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/common/any_params.h"
#include "ratslam/odometry/source.h"

namespace ratslam {

/// Origin of the samples.
enum class OdometryOrigin {
  kImages,  ///< an OdometrySource computes them from images
  kTopic,   ///< a topic of the recording holds them
  kFile,    ///< a separate file holds them; its path is given instead of a name
};

struct OdometryKind {
  std::string name;
  std::string meaning;
  OdometryOrigin origin = OdometryOrigin::kImages;
  bool needs_camera = false;
  std::optional<AnyParams> params;  ///< default values; none if it has no parameters
  /// Makes the source; empty unless the origin is kImages. The camera is given if the source needs one.
  std::function<std::unique_ptr<OdometrySource>(const AnyParams&, const std::optional<CameraModel>&)> make;
};

class OdometryRegistry {
 public:
  /// @throws std::invalid_argument if the name is taken
  template <class Source>
  void add(const std::string& name, const std::string& meaning) {
    using Params = typename Source::Params;
    constexpr bool kNeedsCamera = std::is_constructible_v<Source, const CameraModel&, const Params&>;
    OdometryKind kind{name, meaning, OdometryOrigin::kImages, kNeedsCamera, AnyParams(Params()), nullptr};
    kind.make =
        [](const AnyParams& params,
           [[maybe_unused]] const std::optional<CameraModel>& camera) -> std::unique_ptr<OdometrySource> {
      if constexpr (kNeedsCamera) return std::make_unique<Source>(camera.value(), params.as<Params>());
      if constexpr (!kNeedsCamera) return std::make_unique<Source>(params.as<Params>());
    };
    insert(std::move(kind));
  }
  /// Adds an odometry that is not computed from images.
  void addOutside(const std::string& name, const std::string& meaning, OdometryOrigin origin);

  const std::vector<OdometryKind>& kinds() const { return kinds_; }
  /// The odometry of that name. Any other name is taken for a file.
  /// @throws std::invalid_argument listing all names if there is no such file either
  const OdometryKind& find(const std::string& name) const;

 private:
  void insert(OdometryKind kind);

  std::vector<OdometryKind> kinds_;
};

/// The odometries of this package.
OdometryRegistry standardOdometry();

/// The parameters of all odometries of a registry.
class OdometryParams {
 public:
  OdometryParams() : OdometryParams(standardOdometry()) {}
  explicit OdometryParams(const OdometryRegistry& registry);

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    for (Named& named : all_) named.params.visitFields(visit);
  }
  /// @throws std::invalid_argument naming key, value and bound
  void validate() const;

  /// The parameters of one type. @throws std::out_of_range if no odometry has that type
  template <class Params>
  const Params& of() const {
    for (const Named& named : all_) {
      if (named.params.is<Params>()) return named.params.as<Params>();
    }
    throw std::out_of_range("no odometry has parameters of this type");
  }
  /// Makes the source of a kind with origin kImages.
  /// @throws std::invalid_argument if it needs a camera and there is none, or parameters are bad
  std::unique_ptr<OdometrySource> make(const OdometryKind& kind,
                                       const std::optional<CameraModel>& camera) const;

 private:
  struct Named {
    std::string name;
    AnyParams params;
  };

  std::vector<Named> all_;
};

}  // namespace ratslam
