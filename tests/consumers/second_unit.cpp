// Linked with app/main.cpp: what a header defines and does not say `inline` to is there twice, and does not link.
#include <tilemesh/tilemesh.hpp>
