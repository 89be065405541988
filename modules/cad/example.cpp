// camber.cad: the boundary of a straight mesh put back onto the CAD model that it samples. Placeholder.
#include <cstdio>
#include <fstream>
#include <string>

import camber.core;
import camber.surface;
import camber.cad;

using namespace camber;

int main() { return 0; }
