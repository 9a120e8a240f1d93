#include "ratslam/pose_cells/pose_cells.h"

#include <memory>

#include "conversions.h"
#include "module.h"

namespace ratslam::python {
namespace {

/// The network, held by a shared pointer: an array that shows its activity keeps it alive.
struct Network {
  PoseCellParams params;
  std::shared_ptr<PoseCellNetwork> network;

  explicit Network(const PoseCellParams& p) : params(p), network(std::make_shared<PoseCellNetwork>(p)) {}
};

struct Cells {
  PoseCellParams params;
  std::shared_ptr<PoseCells> cells;

  explicit Cells(const PoseCellParams& p) : params(p), cells(std::make_shared<PoseCells>(p)) {}
};

/// The activity without a copy, read-only; shape (heading, y, x).
template <class Owner>
py::array viewOf(const ActivityGrid& grid, const std::shared_ptr<Owner>& owner) {
  auto* held = new std::shared_ptr<Owner>(owner);
  const py::capsule base(held, [](void* pointer) { delete static_cast<std::shared_ptr<Owner>*>(pointer); });
  py::array_t<double> array({grid.nTh(), grid.nXy(), grid.nXy()}, grid.data(), base);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

ActivityGrid gridFrom(const py::array_t<double, py::array::c_style | py::array::forcecast>& array,
                      const PoseCellParams& params) {
  if (array.ndim() != 3 || array.shape(0) != params.n_th || array.shape(1) != params.n_xy ||
      array.shape(2) != params.n_xy) {
    throw std::invalid_argument(
        "activity: the array must have the shape (pc_dim_th, pc_dim_xy, pc_dim_xy) = (" +
        std::to_string(params.n_th) + ", " + std::to_string(params.n_xy) + ", " +
        std::to_string(params.n_xy) + ")");
  }
  ActivityGrid grid(params.n_xy, params.n_th);
  std::copy(array.data(), array.data() + array.size(), grid.data());
  grid.cover({Box{Span{0, params.n_xy}, Span{0, params.n_xy}, Span{0, params.n_th}}});
  return grid;
}

/// Loads the state into a new object. So arrays that show the old one's activity do not change.
template <class Stage>
void loadInto(std::shared_ptr<Stage>& stage, const PoseCellParams& params, const py::bytes& bytes) {
  auto loaded = std::make_shared<Stage>(params);
  loaded->load(stateFrom(bytes, params));
  stage = loaded;
}

const std::vector<std::string> kActionNames = {"none", "create_node", "create_edge", "set_node"};

ActionKind kindFrom(const std::string& name) {
  for (std::size_t i = 0; i < kActionNames.size(); ++i) {
    if (kActionNames[i] == name) return static_cast<ActionKind>(i);
  }
  throwBadValue("kind", name, "it must be one of none, create_node, create_edge, set_node");
}

}  // namespace

void bindPoseCells(py::module& module) {
  py::class_<PoseCellEstimate>(module, "Estimate", "A place in the network, in continuous cell coordinates.")
      .def_readonly("x", &PoseCellEstimate::x, "[0, pc_dim_xy)")
      .def_readonly("y", &PoseCellEstimate::y, "[0, pc_dim_xy)")
      .def_readonly("th", &PoseCellEstimate::th, "[0, pc_dim_th); layer k faces k * 2 pi / pc_dim_th")
      .def("__iter__", [](const PoseCellEstimate& e) { return py::iter(py::make_tuple(e.x, e.y, e.th)); })
      .def("__repr__", [](const PoseCellEstimate& e) {
        return "Estimate(x=" + std::to_string(e.x) + ", y=" + std::to_string(e.y) +
               ", th=" + std::to_string(e.th) + ")";
      });

  py::class_<Network>(module, "PoseCellNetwork", R"(The continuous attractor network, equations (1) and (2).

Parameters by name: PoseCellNetwork(pc_dim_xy=30, pc_cell_x_size=2.0). The activity sums to 1 and starts in the
centre cell.)")
      .def(py::init([](const py::kwargs& keywords) { return Network(read<PoseCellParams>(keywords)); }))
      .def_property_readonly("parameters", [](const Network& n) { return dictionaryOf(n.params); })
      .def(
          "step", [](Network& n, double distance, double rotation) { n.network->step(distance, rotation); },
          py::arg("distance"), py::arg("rotation"),
          "One odometry step: attract, integrate_path, a new estimate. Distance [m] along the heading, "
          "rotation [rad], counter-clockwise positive.")
      .def(
          "attract", [](Network& n) { n.network->attract(); }, "One iteration of the attractor.")
      .def(
          "integrate_path",
          [](Network& n, double distance, double rotation) { n.network->integratePath(distance, rotation); },
          py::arg("distance"), py::arg("rotation"),
          "Moves the packet, distance [m] and rotation [rad] as in step. The estimate stays as it was.")
      .def(
          "inject",
          [](Network& n, int heading, int y, int x, double energy) {
            const auto within = [](const char* name, int value, int size) {
              if (value < 0 || value >= size)
                throwBadValue(name, value, "it must lie within [0, " + std::to_string(size - 1) + "]");
            };
            within("heading", heading, n.params.n_th);
            within("y", y, n.params.n_xy);
            within("x", x, n.params.n_xy);
            if (!(energy >= 0.0 && energy < 1e9))
              throwBadValue("energy", energy, "it must lie within [0, 1e9)");
            n.network->inject({x, y, heading}, energy);
          },
          py::arg("heading"), py::arg("y"), py::arg("x"), py::arg("energy"),
          "Adds activity to a cell, relative to a sum of 1.")
      .def(
          "set_activity",
          [](Network& n, const py::array_t<double, py::array::c_style | py::array::forcecast>& array) {
            n.network->setActivity(gridFrom(array, n.params));
          },
          py::arg("activity"), "Replaces the activity, (heading, y, x), scaled so that it sums to 1.")
      .def_property_readonly(
          "activity", [](const Network& n) { return viewOf(n.network->activity(), n.network); },
          "(heading, y, x), a read-only view without a copy: it follows every step.")
      .def_property_readonly(
          "estimate", [](const Network& n) { return n.network->estimate(); },
          "Place of the packet after the last step, an Estimate.")
      .def_property_readonly(
          "reseeds", [](const Network& n) { return n.network->reseeds(); },
          "Number of times that all activity had vanished and the network restarted at its last estimate.")
      .def(
          "save", [](const Network& n) { return save(*n.network, n.params); }, "The state as bytes.")
      .def(
          "load", [](Network& n, const py::bytes& bytes) { loadInto(n.network, n.params, bytes); },
          py::arg("state"), "Takes the bytes that save() of a network with the same parameters returned.");

  py::class_<TopologicalAction>(module, "Action", "What the pose cells decide about the map.")
      .def(py::init([](const py::object& stamp, const std::string& kind, std::uint32_t src_id,
                       std::uint32_t dest_id, double relative_rad) {
             TopologicalAction action;
             action.stamp = stampFrom(stamp);
             action.kind = kindFrom(kind);
             action.src_id = src_id;
             action.dest_id = dest_id;
             action.relative_rad = relative_rad;
             return action;
           }),
           py::arg("stamp"), py::arg("kind"), py::arg("src_id"), py::arg("dest_id"),
           py::arg("relative_rad") = 0.0)
      .def_readonly("stamp", &TopologicalAction::stamp, "[ns]")
      .def_property_readonly(
          "kind", [](const TopologicalAction& a) { return kActionNames[static_cast<std::size_t>(a.kind)]; })
      .def_readonly("src_id", &TopologicalAction::src_id, "current experience before the decision")
      .def_readonly("dest_id", &TopologicalAction::dest_id, "current experience after the decision")
      .def_readonly("relative_rad", &TopologicalAction::relative_rad,
                    "heading now relative to that of dest_id [rad]");

  py::class_<Cells>(module, "PoseCells",
                    R"(The network with the view cells' input, equation (3), and the choice of
experiences, equation (5). Within a frame: integrate, activate, decide.)")
      .def(py::init([](const py::kwargs& keywords) { return Cells(read<PoseCellParams>(keywords)); }))
      .def_property_readonly("parameters", [](const Cells& c) { return dictionaryOf(c.params); })
      .def(
          "integrate",
          [](Cells& c, double distance, double rotation) { c.cells->integrate(distance, rotation); },
          py::arg("distance"), py::arg("rotation"),
          "One odometry step: distance [m] along the heading, rotation [rad] counter-clockwise. ValueError "
          "if either is not finite.")
      .def(
          "activate", [](Cells& c, const ViewEvent& view) { c.cells->activate(view); }, py::arg("view"),
          "Ties the view cell of a ViewEvent to the present estimate if it is new; injects activity where it "
          "is tied if it is known.")
      .def(
          "decide", [](Cells& c) { return c.cells->decide(); },
          "Returns the Action for the last step and view, with the stamp of that view.")
      .def_property_readonly(
          "activity", [](const Cells& c) { return viewOf(c.cells->activity(), c.cells); },
          "(heading, y, x), a read-only view without a copy.")
      .def_property_readonly(
          "estimate", [](const Cells& c) { return c.cells->estimate(); },
          "Place of the packet after the last step, an Estimate.")
      .def(
          "save", [](const Cells& c) { return save(*c.cells, c.params); }, "The state as bytes.")
      .def(
          "load", [](Cells& c, const py::bytes& bytes) { loadInto(c.cells, c.params, bytes); },
          py::arg("state"), "Takes the bytes that save() of pose cells with the same parameters returned.");
}

}  // namespace ratslam::python
