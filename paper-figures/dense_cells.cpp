// Clusters of dense cells (G 4.4.1) as a function of the definition of a dense cell. Writes JSON with S (G 4.8), the
// number of clusters and the exponent of their sizes for each frame of a gas's result. These depend on the cell edge
// and on the fraction of close packing of a dense cell.
//
//   dense_cells RESULT.h5

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include <fmt/format.h>

#include "solvers/error.hpp"
#include "src/analysis/gas_clusters.hpp"
#include "src/analysis/gas_shapes.hpp"
#include "src/model/bodies.hpp"
#include "src/record/result.hpp"

using namespace lichtenberg;

namespace {

constexpr double edges[] = {1, 1.5, 2, 2.5, 3, 4, 5};  // d0, approximately
constexpr double parts[] = {1.0 / 6, 1.0 / 3, 1.0 / 2};

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json definition(double edge, double part, const std::vector<Bodies>& frames) {
  const analysis::Cells cells = analysis::cells_of(frames[0], edge);
  const int least = analysis::density_clusters(frames[0], edge, part).least;
  nlohmann::ordered_json json{{"edge", cells.edge.x}, {"part", part}, {"least", least}};
  for (const Bodies& bodies : frames) {
    const analysis::DensityClusters found = analysis::density_clusters(bodies, edge, part);
    const auto exponent = analysis::size_exponent(found.size);
    json["size"].push_back(number(found.mean_size()));
    json["clusters"].push_back(found.size.size());
    json["exponent"].push_back(exponent ? number(exponent->exponent) : number(NAN));
  }
  return json;
}

void tell(const std::string& path) {
  const Result result(path);
  Bodies bodies = make_bodies(result.scene());
  std::vector<Bodies> frames;
  nlohmann::ordered_json json;
  for (int k = 0; k < result.frames(); ++k) {
    bodies.position = result.frame(k).reals("position");
    frames.push_back(bodies);
    json["time"].push_back(result.times()[k]);
  }
  for (const double edge : edges)
    for (const double part : parts) json["definitions"].push_back(definition(edge, part, frames));
  fmt::print("{}\n", json.dump());
}

}  // namespace

int main(int count, char** arguments) try {
  if (count != 2) throw InputError("usage: dense_cells RESULT.h5");
  tell(arguments[1]);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "dense_cells: {}\n", error.what());
  return 2;
}
