#include "schema.hpp"

JDE_EXPORT_PLUGIN("__name__", "0.1.0", "Drives back and forth between two places.", __Name__);
