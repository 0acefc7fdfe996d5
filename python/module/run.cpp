#include "python/module/run.hpp"

#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "python/module/arrays.hpp"
#include "solvers/error.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/recorded_run.hpp"
#include "src/model/bodies.hpp"
#include "src/model/frame.hpp"
#include "src/record/recorder.hpp"

namespace py = pybind11;
using namespace py::literals;

namespace lichtenberg::python {

namespace {

/// Returns the columns by name: for each, the pair of its array ([rows] or [rows, width]; a number for a system column)
/// and its unit.
py::dict columns_of(Frame frame) {
  py::dict columns;
  for (Column& column : frame.columns) {
    const py::ssize_t rows = static_cast<py::ssize_t>(column.rows()), width = static_cast<py::ssize_t>(column.width);
    std::vector<py::ssize_t> shape;
    if (column.of != Column::Of::system) shape.push_back(rows);
    if (width > 0) shape.push_back(width);
    py::object values = std::visit(
        [&](auto& numbers) -> py::object { return array_of(std::move(numbers), std::move(shape)); }, column.values);
    columns[py::str(column.name)] = py::make_tuple(values, column.unit);
  }
  return columns;
}

/// Run of a scene that Python drives, one thread at a time.
class Run {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds check_interval{50};

  /// Calls work() as compute() does. Throws Failure if the run is in use. After a failed step it throws Failure unless
  /// `works_after_failure`.
  template <bool works_after_failure = false, class Work>
  auto exclusively(const Work& work) {
    if (has_failed_ && !works_after_failure)
      throw Failure("this run has failed or was interrupted: save its recorded frames, or create it again");
    if (in_use_.exchange(true))
      throw Failure("this run is computing: another thread or a force function of the run uses it");
    struct Guard {
      std::atomic<bool>& in_use;
      ~Guard() { in_use = false; }
    } guard{in_use_};
    return compute([&] {
      try {
        return work();
      } catch (...) {
        has_failed_ = true;
        throw;
      }
    });
  }

 public:
  /// `file`: result file that is written as by `lichtenberg run --out`; empty: nothing is recorded. `on_warning`
  /// receives texts of warnings.
  Run(Scene scene, const std::string& file, bool overwrite, py::function on_warning) : warn_(std::move(on_warning)) {
    compute_until_interrupt([&] {
      scene = prepare_run(std::move(scene));
      std::optional<Recorder> recorder;
      if (!file.empty()) {
        scene.output.file = file;
        check_not_read(file, {scene.path});
        recorder = Recorder::start(file, scene, make_bodies(scene).mass, overwrite);
      }
      run_.emplace(std::move(scene), std::move(recorder), [this](const std::string& text) { warn(text); });
      run_->begin();
    });
  }

  /// Advances to the next frame. Returns false if the run has ended before. A signal of the keyboard ends the step; the
  /// run may continue if its motion has an exact checkpoint there.
  bool next() {
    std::optional<py::error_already_set> interruption;
    const bool advanced = exclusively([&] {
      if (run_->finished()) return false;
      Clock::time_point last = Clock::now();
      const auto pause = [&] {
        if (Clock::now() - last < check_interval) return false;
        last = Clock::now();
        const py::gil_scoped_acquire lock;
        if (PyErr_CheckSignals() != 0) interruption.emplace();  // takes the exception
        return interruption.has_value();
      };
      try {
        run_->to_next_frame(pause);
      } catch (const Paused&) {
        has_failed_ = true;
      }
      return true;
    });
    if (interruption) throw std::move(*interruption);
    return advanced;
  }

  /// Completes the file of a finished run; otherwise saves a checkpoint if possible. Unlocks the file.
  void end() {
    exclusively<true>([&] {
      if (run_->finished() && !has_failed_) return run_->end();
      if (!has_failed_ && !run_->saved()) run_->save();
      run_->stop();
    });
  }

  py::dict frame() {
    return columns_of(exclusively([&] { return run_->motion().frame(); }));
  }
  /// Returns the number of frames so far.
  std::int64_t count() {
    return exclusively<true>([&] { return run_->frames(); });
  }
  double time() {
    return exclusively<true>([&] { return run_->motion().time(); });
  }
  std::string time_unit() {
    return exclusively<true>([&] { return run_->motion().time_unit(); });
  }
  double end_time() {
    return exclusively([&] { return run_->motion().end_time(); });
  }
  bool finished() {
    return exclusively<true>([&] { return run_->finished() && !has_failed_; });
  }
  bool is_in_one_file() {
    return exclusively<true>([&] { return run_->is_in_one_file(); });
  }
  std::vector<std::string> warnings() {
    return exclusively<true>([&] { return run_->summary().warnings; });
  }
  py::dict summary() {
    const Summary summary = exclusively<true>([&] { return run_->summary(); });
    py::dict quantities;
    for (const Quantity& quantity : summary.quantities)
      quantities[py::str(quantity.name)] = py::make_tuple(quantity.value, quantity.unit);
    return quantities;
  }

 private:
  void warn(const std::string& text) {
    const py::gil_scoped_acquire lock;
    warn_(text);
  }

  py::function warn_;
  std::optional<RecordedRun> run_;
  std::atomic<bool> in_use_ = false, has_failed_ = false;
};

}  // namespace

void register_run(py::module_& module) {
  py::class_<Run>(module, "Run")
      .def(py::init<Scene, const std::string&, bool, py::function>(), "scene"_a, "file"_a, "overwrite"_a, "warn"_a)
      .def("next", &Run::next)
      .def("end", &Run::end)
      .def("frame", &Run::frame)
      .def_property_readonly("count", &Run::count)
      .def_property_readonly("time", &Run::time)
      .def_property_readonly("time_unit", &Run::time_unit)
      .def_property_readonly("end_time", &Run::end_time)
      .def_property_readonly("finished", &Run::finished)
      .def_property_readonly("is_in_one_file", &Run::is_in_one_file)
      .def_property_readonly("summary", &Run::summary)
      .def_property_readonly("warnings", &Run::warnings);
}

}  // namespace lichtenberg::python
