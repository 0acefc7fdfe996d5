#pragma once

/// In front of a loop: write it out so many times; 1: do not. Each compiler has its own word for it.
#define LICHTENBERG_PRAGMA(text) _Pragma(#text)
#ifdef __CUDACC__
#define LICHTENBERG_UNROLL(times) LICHTENBERG_PRAGMA(unroll times)
#else
#define LICHTENBERG_UNROLL(times) LICHTENBERG_PRAGMA(GCC unroll times)
#endif
