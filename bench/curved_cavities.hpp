#pragma once

import camber.core;

/// The scenes of a layer beneath a circle: a split, a collapse, a swap of degree 2.
void print_curved_cavities(const camber::Execution& execution);
