// Some codelets name this header of the SDK without its folder.
#pragma once
#include <poplar/Alignment.hpp>
