#include "ratslam/system/pipeline.h"

#include <Eigen/Geometry>
#include <memory>
#include <stdexcept>

#include "conversions.h"
#include "module.h"
#include "ratslam/odometry/orb/orb_params.h"
#include "ratslam/odometry/possible.h"
#include "ratslam/odometry/registry.h"
#include "ratslam/system/image_stage.h"

namespace ratslam::python {
namespace {

PipelineParams pipelineParams(const py::kwargs& keywords) {
  const ParameterMap map = parametersOf(keywords);
  map.rejectUnknown(PipelineParams::knownKeys());
  return PipelineParams::fromMap(map);
}

/// The odometry of this name that is computed from images. @throws std::invalid_argument naming those that exist
const OdometryKind& kindOfImages(const OdometryRegistry& registry, const std::string& name) {
  std::string list;
  for (const OdometryKind& kind : registry.kinds()) {
    if (kind.origin != OdometryOrigin::kImages) continue;
    if (kind.name == name) return kind;
    list += kind.name + ", ";
  }
  throwBadValue("odometry", "'" + name + "'", "it must be one of " + list + "or external for add_odometry");
}

/// The whole system: image stage and pipeline.
struct System {
  PipelineParams params;
  std::unique_ptr<Pipeline> pipeline;
  std::unique_ptr<ImageStage> images;
  std::string told;  ///< report of the image stage about the last image

  System(const std::string& odometry, const py::kwargs& keywords) : params(pipelineParams(keywords)) {
    std::unique_ptr<OdometrySource> source;
    const std::optional<CameraModel> camera = params.camera.model();
    if (odometry != "external") {
      const OdometryRegistry registry = standardOdometry();
      const OdometryKind& kind = kindOfImages(registry, odometry);
      if (kind.needs_camera && !camera) {
        throwBadValue("odometry", odometry,
                      "it needs the camera: set camera_fx, camera_fy, camera_cx, camera_cy, camera_width_px "
                      "and camera_height_px");
      }
      if (kind.name == "orb") params.odometry.of<OrbOdometryParams>().requireNoCameraFrame();
      source = params.odometry.make(kind, camera);
    }
    pipeline = std::make_unique<Pipeline>(params, std::move(source), camera);
    images = std::make_unique<ImageStage>(params.images,
                                          [this](ImageEvent, const std::string& text) { told = text; });
  }
};

py::dict dictionaryOf(const Pipeline::Progress& progress, std::string told) {
  for (const std::string& why : progress.map_refusals) {
    told += (told.empty() ? "" : "; ") + ("the map cannot process a decision: " + why);
  }
  py::list actions;
  py::list estimates;
  for (const PoseCellDecision& decision : progress.decisions) {
    actions.append(decision.action);
    estimates.append(decision.estimate);
  }
  py::dict dictionary;
  dictionary["views"] = py::cast(progress.views);
  dictionary["actions"] = actions;
  dictionary["estimates"] = estimates;
  dictionary["mapped"] = py::cast(progress.mapped);
  dictionary["told"] = told;
  return dictionary;
}

py::dict addImage(System& system, const py::object& stamp, const py::array& array) {
  system.told.clear();
  const DecodedImage image{stampFrom(stamp), "the image", imageFrom(array), ""};
  const std::optional<ImageFrame> frame = system.images->add(image);
  if (!frame) return dictionaryOf({}, system.told);
  const Pipeline::Progress progress = system.pipeline->addImage(*frame);
  for (const std::string& refusal : progress.refusals) system.images->refused(image.name, refusal);
  return dictionaryOf(progress, system.told);
}

py::dict addOdometry(System& system, const py::object& stamp, double speed, double yaw_rate) {
  if (system.pipeline->odometry() != nullptr) {
    throw std::invalid_argument(
        "odometry: this pipeline computes it from the images; it must be external for add_odometry");
  }
  OdometrySample sample;
  sample.stamp = stampFrom(stamp);
  sample.speed = speed;
  sample.yaw_rate = yaw_rate;
  const std::size_t dropped = system.pipeline->droppedOdometry();
  const Pipeline::Progress progress = system.pipeline->addOdometry(sample);
  if (system.pipeline->droppedOdometry() <= dropped) return dictionaryOf(progress, "");
  const std::string impossible = whyImpossible(sample);
  if (!impossible.empty()) return dictionaryOf(progress, "the sample is dropped: " + impossible);
  const bool taken = !progress.odometry.empty() && progress.odometry.back().stamp == sample.stamp;
  return dictionaryOf(progress, taken ? "the sample before this one is dropped: its stamp lies ahead of time"
                                      : "the sample is dropped: it is not newer than the one before it");
}

py::array_t<double> activityOf(const ActivityGrid& grid) {
  return py::array_t<double>({grid.nTh(), grid.nXy(), grid.nXy()}, grid.data());
}

}  // namespace

void bindPipeline(py::module& module) {
  py::class_<System>(module, "Pipeline",
                     R"(The whole system over images, and over odometry if that comes from outside.

Pipeline(odometry="profile" | "orb" | "external", parameters by name). The results are those of ratslam_run, to the last
bit.)")
      .def(py::init([](const std::string& odometry, const py::kwargs& keywords) {
             return std::make_unique<System>(odometry, keywords);
           }),
           py::arg("odometry") = "profile")
      .def_property_readonly("parameters", [](const System& s) { return dictionaryOf(s.params); })
      .def("add_image", &addImage, py::arg("stamp"), py::arg("image"),
           "An image: (rows, columns) grey or (rows, columns, 3) BGR. Returns a dict: views, actions, "
           "estimates (lists), mapped (stamps [ns] of the actions that the map has processed), told (report "
           "of the image stage and of decisions that the map cannot process, '' if there is none).")
      .def("add_odometry", &addOdometry, py::arg("stamp"), py::arg("speed"), py::arg("yaw_rate"),
           "Motion since the sample before: speed [m/s] forward, yaw_rate [rad/s] counter-clockwise. Returns "
           "a dict as add_image does. A sample that cannot be used is dropped; told is then the reason.")
      .def(
          "end_odometry", [](System& s) { return dictionaryOf(s.pipeline->endOdometry(), ""); },
          "To be called after the last sample, which is held if its stamp jumps ahead. Returns a dict as "
          "add_image does.")
      .def(
          "settle", [](System& s) { s.pipeline->settle(); },
          "Improves the map until it changes no more, as ratslam_run does at the end.")
      .def_property_readonly(
          "activity", [](const System& s) { return activityOf(s.pipeline->poseCells().cells().activity()); },
          "Of the pose cells, (heading, y, x), a copy.")
      .def_property_readonly(
          "estimate", [](const System& s) { return s.pipeline->poseCells().cells().estimate(); },
          "Place of the packet after the last step, an Estimate.")
      .def_property_readonly(
          "templates", [](const System& s) { return s.pipeline->localView().size(); },
          "Number of learned templates.")
      .def(
          "template",
          [](const System& s, std::uint32_t id) {
            return arrayFrom(s.pipeline->localView().templateImage(id));
          },
          py::arg("id"),
          "A template as a picture, (rows, columns) of uint8. IndexError if there is none of this number.")
      .def_property_readonly(
          "experiences", [](const System& s) { return experiencesOf(s.pipeline->map().graph()); },
          "(experiences, 5): x, y, z [m], yaw [rad], log-scale")
      .def_property_readonly(
          "links", [](const System& s) { return linksOf(s.pipeline->map().graph()); },
          "Dict of arrays as ExperienceMap.links.")
      .def_property_readonly(
          "online_trajectory",
          [](const System& s) { return arrayFrom(s.pipeline->map().onlineTrajectory()); },
          "(poses, 6): stamp [s], x, y, z [m], yaw [rad], log-scale")
      .def_property_readonly(
          "final_trajectory", [](const System& s) { return arrayFrom(s.pipeline->map().finalTrajectory()); },
          "(poses, 6): the same path in the present map.");
}

}  // namespace ratslam::python
