/*
 * Schemas in C++17: everything that a plugin needs. docs/cpp.md explains it.
 */
#ifndef JDE_HPP
#define JDE_HPP

#include "jde/geometry.hpp"
#include "jde/plugin.hpp"

#endif
