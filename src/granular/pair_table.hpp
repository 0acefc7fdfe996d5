#pragma once

#include <array>
#include <cstddef>
#include <experimental/simd>
#include <utility>
#include <vector>

#include "src/granular/lanes.hpp"

namespace lichtenberg::granular {

/// SIMD vector of doubles, one for each of `width` pairs. Files that include this header must be compiled without
/// contraction of products and sums. A pair thus has bitwise identical results in any lane and with any vector width.
using SimdPack = std::experimental::native_simd<double>;
inline constexpr int width = SimdPack::size();
inline constexpr auto anywhere = std::experimental::element_aligned;

/// Indices of `width` successive pairs, which are computed together in a SIMD vector.
struct Row {
  int first;
  int operator[](int lane) const { return first + lane; }
};
/// Indices of `width` arbitrary pairs, which are computed together in a SIMD vector.
struct SelectedPairs {
  std::array<int, width> pairs;
  int operator[](int lane) const { return pairs[lane]; }
};

/// Storage of columns (arrays with one number for each pair). The values of all columns for a row of `width` pairs are
/// contiguous, so that loops over all columns read memory sequentially.
class Table {
 public:
  void resize(std::size_t pairs) { values_.resize(pairs * columns_); }
  int add_column() { return columns_++; }
  /// Returns the index in values_ of a column's value for a pair.
  std::size_t index(int column, int pair) const {
    return (static_cast<std::size_t>(pair / width) * columns_ + column) * width + pair % width;
  }
  double* at(std::size_t index) { return &values_[index]; }
  const double* at(std::size_t index) const { return &values_[index]; }

 private:
  int columns_ = 0;
  std::vector<double> values_;
};

/// Column of a Table: one number for each pair.
class Column {
 public:
  explicit Column(Table& table) : table_(&table), number_(table.add_column()) {}
  double& operator[](int pair) { return *table_->at(table_->index(number_, pair)); }
  double operator[](int pair) const { return *std::as_const(*table_).at(table_->index(number_, pair)); }

  SimdPack at(Row row) const {
    return SimdPack(std::as_const(*table_).at(table_->index(number_, row.first)), anywhere);
  }
  SimdPack at(const SelectedPairs& of) const {
    return SimdPack([&](int lane) { return (*this)[of[lane]]; });
  }
  void put(Row row, const SimdPack& x) { x.copy_to(&(*this)[row.first], anywhere); }
  void put(const SelectedPairs& of, const SimdPack& x) {
    for (int lane = 0; lane < width; ++lane) (*this)[of[lane]] = x[lane];
  }

 private:
  Table* table_;
  int number_;
};

template <int d>
using Vectors = LaneVec<d, SimdPack>;

/// Columns of a Table for the components of a vector for each pair.
template <int d>
class VectorColumn {
 public:
  explicit VectorColumn(Table& table) {
    for (int k = 0; k < d; ++k) components_.emplace_back(table);
  }
  Vec<d> operator[](int pair) const {
    Vec<d> v;
    for (int k = 0; k < d; ++k) v[k] = components_[k][pair];
    return v;
  }
  template <class Indices>
  Vectors<d> at(const Indices& of) const {
    return Vectors<d>::each([&](int k) { return components_[k].at(of); });
  }
  template <class Indices>
  void put(const Indices& of, const Vectors<d>& x) {
    for (int k = 0; k < d; ++k) components_[k].put(of, x[k]);
  }

 private:
  std::vector<Column> components_;
};

/// Returns the sum of the first `count` numbers of a column, in an order that does not depend on the vector width.
inline double total(const Column& of, int count) {
  std::array<double, 8> sums{};
  for (int p = 0; p < count; ++p) sums[p % 8] += of[p];
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

}  // namespace lichtenberg::granular
