#include "wall.hpp"

JDE_EXPORT_PLUGIN("wall", "0.1.0", "Follows a wall that Eigen fits.", Finder, Follow);
