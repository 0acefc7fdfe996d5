#pragma once

/// Placed in front of a loop: unrolls it `times` times; 1: not at all. Compilers have different pragmas.
#define LICHTENBERG_PRAGMA(text) _Pragma(#text)
#ifdef __CUDACC__
#define LICHTENBERG_UNROLL(times) LICHTENBERG_PRAGMA(unroll times)
#else
#define LICHTENBERG_UNROLL(times) LICHTENBERG_PRAGMA(GCC unroll times)
#endif
