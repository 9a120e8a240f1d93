#include <algorithm>

#include "conversions.h"
#include "module.h"
#include "ratslam/local_view/local_view_cells.h"

namespace ratslam::python {
namespace {

/// The cells and the last view.
struct Cells {
  LocalViewCells cells;
  View seen;

  explicit Cells(const LocalViewParams& params) : cells(params) {}

  ViewEvent observe(Stamp stamp, const cv::Mat& image) {
    seen = cells.describe(image);
    return cells.observe(stamp, seen, image, ViewMotion::oneStep());
  }
  void save(State& state) const {
    cells.save(state.child("cells"));
    state.set("seen", seen);
  }
  void load(const State& state) {
    cells.load(state.child("cells"));
    state.get("seen", seen);
  }
};

py::array_t<float> arrayFrom(const ViewLikeness& likeness) {
  py::array_t<float> array({likeness.variants, likeness.places});
  std::copy(likeness.values.begin(), likeness.values.end(), array.mutable_data());
  return array;
}

}  // namespace

void bindLocalView(py::module& module) {
  py::class_<ViewEvent>(module, "ViewEvent", "The view cell that an image made active.")
      .def(py::init([](const py::object& stamp, std::uint32_t id, double relative_rad) {
             ViewEvent event;
             event.stamp = stampFrom(stamp);
             event.id = id;
             event.relative_rad = relative_rad;
             return event;
           }),
           py::arg("stamp"), py::arg("id"), py::arg("relative_rad") = 0.0)
      .def_readonly("stamp", &ViewEvent::stamp, "[ns]")
      .def_readonly("id", &ViewEvent::id, "number of its template")
      .def_readonly("relative_rad", &ViewEvent::relative_rad, "heading now relative to the template's [rad]")
      .def_readonly("error", &ViewEvent::error, "of the best candidate, -1 where there was none")
      .def_readonly("learned", &ViewEvent::learned, "the template is new");

  py::class_<Cells>(module, "LocalViewCells",
                    R"(Each image makes one view cell active, a learned one or a new one.

Parameters by name: LocalViewCells(template_x_size=60, template_y_size=10, vt_match_threshold=0.04).)")
      .def(py::init([](const py::kwargs& keywords) {
        return std::make_unique<Cells>(read<LocalViewParams>(keywords));
      }))
      .def_property_readonly("parameters",
                             [](const Cells& cells) { return dictionaryOf(cells.cells.params()); })
      .def(
          "observe",
          [](Cells& cells, const py::object& stamp, const py::array& image) {
            return cells.observe(stampFrom(stamp), imageFrom(image));
          },
          py::arg("stamp"), py::arg("image"),
          "The view event of an image: (rows, columns) grey or (rows, columns, 3) BGR. An int stamp counts "
          "nanoseconds, a float seconds.")
      .def(
          "__len__", [](const Cells& cells) { return cells.cells.size(); }, "Number of learned templates.")
      .def(
          "template",
          [](const Cells& cells, std::uint32_t id) { return arrayFrom(cells.cells.templateImage(id)); },
          py::arg("id"), "A template as a picture, (rows, columns) of uint8.")
      .def_property_readonly(
          "view", [](const Cells& cells) { return arrayFrom(cells.cells.viewImage()); },
          "The view of the last image as a picture, (rows, columns) of uint8.")
      .def_property_readonly(
          "memory_bytes", [](const Cells& cells) { return cells.cells.memoryBytes(); },
          "Bytes that the templates and the belief over places take.")
      .def_property_readonly(
          "likeness", [](Cells& cells) { return arrayFrom(cells.cells.likeness(cells.seen)); },
          "Likeness of each template to the last image, (shifts, templates) of float32; larger is more "
          "alike: the graded activity of equation (3).")
      .def(
          "save", [](const Cells& cells) { return save(cells, cells.cells.params()); }, "The state as bytes.")
      .def(
          "load",
          [](Cells& cells, const py::bytes& bytes) {
            Cells loaded(cells.cells.params());  // a refused state changes nothing
            loaded.load(stateFrom(bytes, cells.cells.params()));
            cells = std::move(loaded);
          },
          py::arg("state"), "Takes the bytes that save() of cells with the same parameters returned.");
}

}  // namespace ratslam::python
