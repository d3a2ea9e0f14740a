#include "schema.hpp"

JDE_EXPORT_PLUGIN("creep-cpp", "0.1.0", "Drives up to the obstacle ahead.", CreepCpp);
