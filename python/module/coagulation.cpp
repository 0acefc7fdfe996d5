#include "python/module/coagulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "python/module/arrays.hpp"
#include "solvers/error.hpp"
#include "src/theory/smoluchowski.hpp"

namespace py = pybind11;

namespace lichtenberg::python {

py::dict coagulate(const py::function& kernel, const std::vector<double>& times, double tolerance, double largest,
                   bool stiff) {
  const bool allowed = std::ranges::all_of(times, [](double t) { return t >= 0 && std::isfinite(t); });
  if (times.empty() || !allowed || !std::ranges::is_sorted(times))
    throw InputError("coagulate: times must be a list of ascending numbers, at least 0");
  if (!(tolerance >= 1e-8 && tolerance < 1) || !(largest >= 2 && largest <= 1e9))
    throw InputError("coagulate: tolerance must be from 1e-8 to 1, and largest from 2 to 1e9");
  const auto value = [&](double i, double j) {
    const double k = kernel(i, j).cast<double>();
    if (!(k >= 0 && std::isfinite(k)))
      throw InputError(
          fmt::format("coagulate: the kernel of sizes {:g} and {:g} is {:g}: it must be at least 0", i, j, k));
    return k;
  };
  const theory::CoagulationSeries found =
      theory::coagulation_series(value, times, {.tolerance = tolerance, .largest = largest, .stiff = stiff});
  const auto n = static_cast<py::ssize_t>(found.size.size());
  py::dict result;
  result["time"] = array_of(std::vector(times.begin(), times.begin() + n), {n});
  result["size"] = array_of(std::vector(found.size), {n});
  result["number"] = array_of(std::vector(found.number), {n});
  result["width"] = array_of(found.relative_width(), {n});
  result["error"] = found.error;
  result["lost"] = found.lost;
  return result;
}

}  // namespace lichtenberg::python
