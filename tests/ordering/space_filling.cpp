#include <doctest/doctest.h>
int x;
