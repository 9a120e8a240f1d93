/// The odometries there are, by name: what command lines, configurations and help know of them comes from
/// here.
///
/// To add one: write a class that is an OdometrySource (source.h) and has
///
///     using Params = ...;                                    // a parameter struct (common/params.h)
///     MySource(const Params&);                               // or, where it needs the camera's calibration,
///     MySource(const CameraModel&, const Params&);
///
/// and add one line to standardOdometry() in registry.cpp:
///
///     registry.add<MySource>("mine", "what it is");
///
/// Its parameters are then read, checked, listed and written like those of the others.
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

/// Where the samples come from.
enum class OdometryOrigin {
  kImages,  ///< an OdometrySource makes them
  kTopic,   ///< they lie among the images of a recording
  kFile,    ///< they lie in a file of their own, which is named instead of the odometry
};

struct OdometryKind {
  std::string name;
  std::string meaning;
  OdometryOrigin origin = OdometryOrigin::kImages;
  bool needs_camera = false;
  std::optional<AnyParams> params;  ///< at their defaults; none where there are none
  /// Makes the source; none where it is not made of images. The camera is there where it is needed.
  std::function<std::unique_ptr<OdometrySource>(const AnyParams&, const std::optional<CameraModel>&)> make;
};

class OdometryRegistry {
 public:
  /// @throws std::invalid_argument where the name is taken
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
  /// An odometry that is not made of images.
  void addOutside(const std::string& name, const std::string& meaning, OdometryOrigin origin);

  const std::vector<OdometryKind>& kinds() const { return kinds_; }
  /// The one of that name; a name of none is taken for a file.
  /// @throws std::invalid_argument naming all there are where there is no such file either
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

  /// Those of one type. @throws std::out_of_range where no odometry has it
  template <class Params>
  const Params& of() const {
    for (const Named& named : all_) {
      if (named.params.is<Params>()) return named.params.as<Params>();
    }
    throw std::out_of_range("no odometry has parameters of this type");
  }
  /// The source of a kind that is made of images.
  /// @throws std::invalid_argument where it needs a camera and there is none, or parameters are bad
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
