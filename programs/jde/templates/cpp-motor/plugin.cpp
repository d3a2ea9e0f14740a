#include "schema.hpp"

JDE_EXPORT_PLUGIN("__name__", "0.1.0", "Drives up to the obstacle ahead.", __Name__);
