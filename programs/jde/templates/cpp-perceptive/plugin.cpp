#include "schema.hpp"

JDE_EXPORT_PLUGIN("__name__", "0.1.0", "Finds the nearest obstacle.", __Name__, Face);
