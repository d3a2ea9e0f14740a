#include "tracker.hpp"

JDE_EXPORT_PLUGIN("tracker", "0.1.0", "Tracks a colour with OpenCV.", Tracker, Chase);
