// A stand-in for the header of the same name in the Poplar SDK: fields are declared in Vertex.hpp.
#pragma once
#include <poplar/Vertex.hpp>
