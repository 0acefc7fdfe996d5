// Runner of doctest, compiled once for all programs that include its header.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
