#pragma once

#include <array>
#include <cstddef>
#include <experimental/simd>
#include <utility>
#include <vector>

#include "src/granular/lanes.hpp"

namespace lichtenberg::granular {

/// As many numbers as the processor computes with together. Who includes this is compiled without contraction of
/// products and sums, so that a pair's result has the same bits in any lane and with any number of them.
using Several = std::experimental::native_simd<double>;
inline constexpr int width = Several::size();
inline constexpr auto anywhere = std::experimental::element_aligned;

/// Pairs that are computed together: they follow each other, or are picked.
struct Row {
  int first;
  int operator[](int lane) const { return first + lane; }
};
struct Picked {
  std::array<int, width> pairs;
  int operator[](int lane) const { return pairs[lane]; }
};

/// Columns of numbers of pairs. Those of a row of pairs lie together: loops over all columns read memory as it comes.
class Table {
 public:
  void resize(std::size_t pairs) { values_.resize(pairs * columns_); }
  int add_column() { return columns_++; }
  std::size_t place(int column, int pair) const {
    return (static_cast<std::size_t>(pair / width) * columns_ + column) * width + pair % width;
  }
  double* at(std::size_t place) { return &values_[place]; }
  const double* at(std::size_t place) const { return &values_[place]; }

 private:
  int columns_ = 0;
  std::vector<double> values_;
};

/// A number of each pair.
class Column {
 public:
  explicit Column(Table& table) : table_(&table), number_(table.add_column()) {}
  double& operator[](int pair) { return *table_->at(table_->place(number_, pair)); }
  double operator[](int pair) const { return *std::as_const(*table_).at(table_->place(number_, pair)); }

  Several at(Row row) const { return Several(std::as_const(*table_).at(table_->place(number_, row.first)), anywhere); }
  Several at(const Picked& of) const {
    return Several([&](int lane) { return (*this)[of[lane]]; });
  }
  void put(Row row, const Several& x) { x.copy_to(&(*this)[row.first], anywhere); }
  void put(const Picked& of, const Several& x) {
    for (int lane = 0; lane < width; ++lane) (*this)[of[lane]] = x[lane];
  }

 private:
  Table* table_;
  int number_;
};

template <int d>
using Vectors = LaneVec<d, Several>;

template <int d>
class VectorColumn {
 public:
  explicit VectorColumn(Table& table) {
    for (int k = 0; k < d; ++k) of_.emplace_back(table);
  }
  Vec<d> operator[](int pair) const {
    Vec<d> v;
    for (int k = 0; k < d; ++k) v[k] = of_[k][pair];
    return v;
  }
  template <class Those>
  Vectors<d> at(const Those& of) const {
    return Vectors<d>::each([&](int k) { return of_[k].at(of); });
  }
  template <class Those>
  void put(const Those& of, const Vectors<d>& x) {
    for (int k = 0; k < d; ++k) of_[k].put(of, x[k]);
  }

 private:
  std::vector<Column> of_;
};

/// The sum, in an order that is that of the numbers alone.
inline double total(const Column& of, int count) {
  std::array<double, 8> sums{};
  for (int p = 0; p < count; ++p) sums[p % 8] += of[p];
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

}  // namespace lichtenberg::granular
