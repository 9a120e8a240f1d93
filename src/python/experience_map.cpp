#include "ratslam/experience_map/experience_map.h"

#include <stdexcept>

#include "conversions.h"
#include "module.h"

namespace ratslam::python {
namespace {

struct Map {
  ExperienceMapParams params;
  std::unique_ptr<ExperienceMap> map;

  explicit Map(const ExperienceMapParams& p) : params(p), map(std::make_unique<ExperienceMap>(p)) {}
};

py::tuple tupleOf(const MapPose& pose) {
  return py::make_tuple(pose.x, pose.y, pose.z, pose.yaw, pose.log_scale);
}

}  // namespace

py::array_t<double> experiencesOf(const ExperienceGraph& graph) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(graph.experiences().size()), static_cast<py::ssize_t>(5)});
  double* value = array.mutable_data();
  for (const Experience& experience : graph.experiences()) {
    const MapPose& pose = experience.pose;
    for (const double number : {pose.x, pose.y, pose.z, pose.yaw, pose.log_scale}) *value++ = number;
  }
  return array;
}

py::dict linksOf(const ExperienceGraph& graph) {
  const auto count = static_cast<py::ssize_t>(graph.links().size());
  py::array_t<std::uint32_t> ends({count, static_cast<py::ssize_t>(2)});
  py::array_t<bool> recall(count);
  py::array_t<double> measured({count, static_cast<py::ssize_t>(5)});
  for (py::ssize_t i = 0; i < count; ++i) {
    const Link& link = graph.links()[static_cast<std::size_t>(i)];
    ends.mutable_at(i, 0) = link.from;
    ends.mutable_at(i, 1) = link.to;
    recall.mutable_at(i) = link.recall;
    py::ssize_t column = 0;
    for (const double number :
         {link.distance, link.heading_rad, link.facing_rad, link.rise, link.duration_s}) {
      measured.mutable_at(i, column++) = number;
    }
  }
  py::dict links;
  links["ends"] = ends;
  links["recall"] = recall;
  links["measured"] = measured;
  return links;
}

void bindExperienceMap(py::module& module) {
  py::class_<Map>(module, "ExperienceMap", R"(The graph of places, the robot's pose in it and its trajectory.

Parameters by name: ExperienceMap(exp_solver="graph", exp_recall_sigma=0.5). At each stamp: integrate the odometry,
then apply the pose cells' decision.)")
      .def(py::init([](const py::kwargs& keywords) { return Map(read<ExperienceMapParams>(keywords)); }))
      .def_property_readonly("parameters", [](const Map& m) { return dictionaryOf(m.params); })
      .def(
          "start", [](Map& m, const py::object& stamp) { m.map->start(stampFrom(stamp)); }, py::arg("stamp"),
          "Sets the clock: the stamp of the first odometry.")
      .def(
          "integrate",
          [](Map& m, const py::object& stamp, double forward, double rotation, double left, double up) {
            OdometryStep step;
            step.forward = forward;
            step.rotation = rotation;
            step.left = left;
            step.up = up;
            m.map->integrate(stampFrom(stamp), step);
          },
          py::arg("stamp"), py::arg("forward"), py::arg("rotation"), py::arg("left") = 0.0,
          py::arg("up") = 0.0,
          "Motion from the newest stamp up to this one: forward, left, up [m], rotation [rad] "
          "counter-clockwise. ValueError before start, if time runs backwards, or for a number that is not "
          "finite.")
      .def(
          "apply", [](Map& m, const TopologicalAction& action) { m.map->apply(action); }, py::arg("action"),
          "Carries out an Action of the pose cells, after integrate up to its stamp. ValueError if an "
          "experience does not exist or a new one does not have the next number; the map is then unchanged.")
      .def(
          "settle", [](Map& m) { m.map->settle(); }, "Finishes the solver's remaining work.")
      .def_property_readonly(
          "robot_pose", [](const Map& m) { return tupleOf(m.map->robotPose()); },
          "x, y, z [m], yaw [rad], log-scale")
      .def_property_readonly(
          "experiences", [](const Map& m) { return experiencesOf(m.map->graph()); },
          "(experiences, 5): x, y, z [m], yaw [rad], log-scale")
      .def_property_readonly(
          "links", [](const Map& m) { return linksOf(m.map->graph()); },
          "Dict: ends (links, 2), experiences from and to; recall (links,), whether a recall made the link; "
          "measured (links, 5): distance [m], heading [rad], change of facing [rad], rise [m], duration [s]")
      .def_property_readonly(
          "online_trajectory", [](const Map& m) { return arrayFrom(m.map->onlineTrajectory()); },
          "(poses, 6): stamp [s], x, y, z [m], yaw [rad], log-scale, as estimated at the time")
      .def_property_readonly(
          "final_trajectory", [](const Map& m) { return arrayFrom(m.map->finalTrajectory()); },
          "(poses, 6): the same path in the present map.")
      .def(
          "save", [](const Map& m) { return save(*m.map, m.params); }, "The state as bytes.")
      .def(
          "load",
          [](Map& m, const py::bytes& bytes) {
            auto loaded = std::make_unique<ExperienceMap>(m.params);
            loaded->load(stateFrom(bytes, m.params));
            m.map = std::move(loaded);
          },
          py::arg("state"), "Takes the bytes that save() of a map with the same parameters returned.");
}

}  // namespace ratslam::python
