#pragma once

import camber.core;

/// Prints the scenes of a layer below a circle: a quadratic split, collapse and swap.
void print_curved_cavities(const camber::Execution& execution);
