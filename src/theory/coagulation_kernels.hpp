#pragma once

#include <vector>

#include "src/theory/smoluchowski.hpp"

namespace lichtenberg::theory {

/// Returns the kernel (i^(1/3) + j^(1/3)) (i^(-1/3) + j^(-1/3)) of spheres that diffuse, in units of 2 T/(3 eta) with
/// the viscosity eta (Smoluchowski 1916). It is homogeneous of degree 0.
Kernel brownian_kernel();

/// Returns the kernel (i^mu j^nu + i^nu j^mu) / 2: 1 for mu = nu = 0, the mean size for (1, 0), the product for (1, 1).
/// If mu or nu exceeds 1, or mu + nu exceeds 1, mass is lost to infinite sizes after a finite time.
Kernel power_kernel(double mu, double nu);

/// Returns the kernel times x/(e^x - 1), with the energy x = 2 repulsion i j / (i^(1/3) + j^(1/3)) of two touching
/// spheres over the temperature. Their charges are proportional to their sizes, they diffuse, and no medium screens
/// their field (Fuchs 1934). `repulsion` is the x of two single grains.
Kernel repelled(Kernel kernel, double repulsion);

/// Returns the largest size at which two equal aggregates still merge with repelled() at a rate above 1e-300 of their
/// kernel.
double largest_repelled_size(double repulsion);

/// Kernel by values on a grid of sizes.
struct KernelTable {
  std::vector<double> size;                ///< [n], n >= 2, ascending and positive
  std::vector<std::vector<double>> value;  ///< [n][n], positive and symmetric
};

/// Returns the kernel whose logarithm is bilinear in the logarithms of both sizes between the values of the table, and
/// continues beyond its first and last sizes. A power law is exact. Throws InputError for a table that is not as
/// KernelTable states.
Kernel table_kernel(KernelTable table);

}  // namespace lichtenberg::theory
