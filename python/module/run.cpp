#include "python/module/run.hpp"

#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "python/module/arrays.hpp"
#include "solvers/error.hpp"
#include "src/commands/recorded_run.hpp"
#include "src/model/bodies.hpp"
#include "src/record/recorder.hpp"

namespace py = pybind11;
using namespace py::literals;

namespace lichtenberg::python {

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

namespace {

/// Run of a scene that Python drives. One thread at a time may use it; without the interpreter lock while it computes.
class Run {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds check_interval{50};

  /// Calls work() without the interpreter lock. Throws Failure if another thread uses the run, or after a failed step.
  template <class Work>
  auto use(const Work& work) {
    if (failed_) throw Failure("this run has failed or was interrupted: make it again from its scene");
    if (in_use_.exchange(true)) throw Failure("this run is in use by another thread");
    struct Guard {
      std::atomic<bool>& in_use;
      ~Guard() { in_use = false; }
    } guard{in_use_};
    const py::gil_scoped_release unlocked;
    try {
      return work();
    } catch (...) {
      failed_ = true;
      throw;
    }
  }

 public:
  /// `file`: result file that is written as by `lichtenberg run --out`; empty: nothing is recorded. `on_warning`
  /// receives texts of warnings.
  Run(const Scene& scene, const std::string& file, bool overwrite, py::function on_warning)
      : warn_(std::move(on_warning)) {
    const py::gil_scoped_release unlocked;
    Scene prepared = prepare_run(scene);
    std::optional<Recorder> recorder;
    if (!file.empty()) {
      prepared.output.file = file;
      recorder = Recorder::start(file, prepared, make_bodies(prepared).mass, overwrite);
    }
    run_ =
        std::make_unique<RecordedRun>(prepared, std::move(recorder), [this](const std::string& text) { warn(text); });
  }

  void begin() {
    use([&] { run_->begin(); });
  }

  /// Advances to the next frame. Returns false if the run has ended before. A signal of the keyboard ends the step.
  bool next() {
    return use([&] {
      if (run_->finished()) return false;
      bool interrupted = false;
      Clock::time_point last = Clock::now();
      const auto pause = [&] {
        if (Clock::now() - last < check_interval) return false;
        last = Clock::now();
        const py::gil_scoped_acquire lock;
        return interrupted = PyErr_CheckSignals() != 0;
      };
      try {
        run_->to_next_frame(pause);
      } catch (const Paused&) {
        throw_interruption(interrupted);
      }
      if (interrupted) throw_interruption(true);
      return true;
    });
  }

  /// Completes the file of a finished run.
  void end() {
    use([&] { run_->end(); });
  }

  /// Saves the run so far, from which `--resume` continues, and unlocks the file.
  void stop() {
    use([&] {
      if (!run_->saved()) run_->save();
      run_->stop();
    });
  }

  py::dict frame() {
    Frame now = use([&] { return run_->motion().frame(); });
    return columns_of(std::move(now));
  }

  double time() {
    return use([&] { return run_->motion().time(); });
  }
  std::string time_unit() {
    return use([&] { return run_->motion().time_unit(); });
  }
  bool finished() {
    return use([&] { return run_->finished(); });
  }
  double end_time() {
    return use([&] { return run_->motion().end_time(); });
  }

  py::dict summary() {
    py::dict quantities;
    for (const Quantity& quantity : run_->summary().quantities)
      quantities[py::str(quantity.name)] = py::make_tuple(quantity.value, quantity.unit);
    return quantities;
  }
  std::vector<std::string> warnings() { return run_->summary().warnings; }

 private:
  [[noreturn]] static void throw_interruption(bool by_signal) {
    const py::gil_scoped_acquire lock;
    if (by_signal) throw py::error_already_set();
    throw Failure("the run was paused at an instant without an exact checkpoint");
  }

  void warn(const std::string& text) {
    const py::gil_scoped_acquire lock;
    warn_(text);
  }

  py::function warn_;
  std::unique_ptr<RecordedRun> run_;
  std::atomic<bool> in_use_ = false, failed_ = false;
};

}  // namespace

void register_run(py::module_& module) {
  py::class_<Run>(module, "Run")
      .def(py::init<const Scene&, const std::string&, bool, py::function>(), "scene"_a, "file"_a, "overwrite"_a,
           "warn"_a)
      .def("begin", &Run::begin)
      .def("next", &Run::next)
      .def("end", &Run::end)
      .def("stop", &Run::stop)
      .def("frame", &Run::frame)
      .def_property_readonly("time", &Run::time)
      .def_property_readonly("time_unit", &Run::time_unit)
      .def_property_readonly("end_time", &Run::end_time)
      .def_property_readonly("finished", &Run::finished)
      .def_property_readonly("summary", &Run::summary)
      .def_property_readonly("warnings", &Run::warnings);
}

}  // namespace lichtenberg::python
